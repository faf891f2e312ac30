"""Options that several commands share, and the robot, world and q that they name. Used by every command."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.cli.numbers import numbers
from ulna.cli.output import warn
from ulna.collision.scene_file import load_world
from ulna.collision.world import World
from ulna.errors import DescriptionWarning, InputError
from ulna.robot import Robot, load
from ulna.robot.coordinates import coordinates_of
from ulna.robot.hand_link import hand_link


def _names_that_begin(incomplete: str) -> list[str]:
    """The names of installed robots that begin so, for shell completion."""
    from ulna.description.names.by_name import known_robots  # noqa: PLC0415 -- only a shell asks

    names = [name for robot in known_robots() if robot.installed for name in (robot.name, *robot.also)]
    return [name for name in names if name.startswith(incomplete)]


RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A name of `ulna list`, or the path of a .urdf or .xacro file.",
        autocompletion=_names_that_begin,
    ),
]
XacroArgs = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="KEY:=VALUE", help="An argument of a xacro file; repeatable.")
]
PackageDirs = Annotated[
    list[Path] | None, typer.Option("--package-dir", metavar="FOLDER", help="A folder that holds ROS packages; repeatable.")
]
Base = Annotated[str | None, typer.Option(metavar="LINK", help="The link to begin at; the root unless given.")]
Tip = Annotated[str | None, typer.Option(metavar="LINK", help="The link to end at: only the chain to it is kept.")]
SrdfFile = Annotated[
    Path | None, typer.Option("--srdf", metavar="FILE", help="A semantic description: groups, pairs of links that may touch.")
]
Link = Annotated[
    str | None, typer.Option(metavar="NAME", help="The link; unless given the tip or, where there are several, the hand.")
]
Positions = Annotated[
    str | None, typer.Option("--q", metavar="NUMBERS", help='Joint positions, as in "0,-pi/4,0.5 1e-3"; home unless given.')
]
Degrees = Annotated[bool, typer.Option("--degrees", help="All angles given are degrees, not radians.")]
Scene = Annotated[Path | None, typer.Option(metavar="FILE", help="A scene file: the obstacles, as `ulna view` saves them.")]
NoOpen = Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object instead of tables: metres and radians, infinity is null.")]
SERVED = {"host": "--host", "port": "--port"}  # arguments of a page, and the options that set them


@contextmanager
def as_options(names: Mapping[str, str]) -> Iterator[None]:
    """A context for a call of the library, in which an ``InputError`` names the option instead of the argument.

    Args:
        names: The option of each argument, as in ``{"host": "--host"}``.

    Raises:
        InputError: The library refuses an argument.
    """
    try:
        yield
    except InputError as error:
        raise InputError(names.get(error.argument, error.argument), error.message) from None


def load_robot(
    robot: str,
    xacro_arg: Sequence[str] | None,
    package_dir: Sequence[Path] | None,
    *,
    base: str | None = None,
    tip: str | None = None,
    srdf: Path | None = None,
) -> Robot:
    """The robot that the options name. Warnings about unknown names in an SRDF are printed on standard error.

    Raises:
        UlnaError: It cannot be loaded; see ``ulna.load``.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DescriptionWarning)
        arm = load(robot, xacro_args=xacro_arguments(xacro_arg), package_dirs=package_dir or (), base=base, tip=tip, srdf=srdf)
    for warning in caught:
        warn(str(warning.message))
    return arm


def link_or_hand(robot: Robot, link: str | None, *, quietly: bool) -> str:
    """The named link; otherwise the tip; otherwise the hand, whose name is printed on standard error unless ``quietly``."""
    known = robot.tip if link is None else link
    if known is not None:
        return known
    hand = hand_link(robot)
    if not quietly:
        warn(f"{robot.name} has {len(robot.tree.leaves)} tips; {hand} is taken, --link names another")
    return hand


def xacro_arguments(xacro_arg: Sequence[str] | None) -> dict[str, str]:
    """The arguments of a xacro file, from key:=value.

    Raises:
        InputError: One of them does not have this form.
    """
    arguments = {}
    for text in xacro_arg or ():
        key, separator, value = text.partition(":=")
        if not (separator and key):
            raise InputError("--xacro-arg", f"{text!r}; key:=value is expected")
        arguments[key] = value
    return arguments


def world_of(scene: Path | None) -> World:
    """The world of a scene file; an empty one without it.

    Raises:
        UlnaError: The file cannot be read.
    """
    return World() if scene is None else load_world(scene)


def positions(option: str, text: str | None, robot: Robot, *, degrees: bool) -> NDArray[np.float64]:
    """The numbers of an option as one q [rad or m], shape (n_dof,); home without it.

    Raises:
        InputError: They are not the numbers of one q.
    """
    if text is None:
        return robot.home
    return np.array(numbers(option, text, coordinates_of(robot), degrees=degrees))
