"""Options that several commands share, and the robot, world and q that they name. Used by every command."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.cli.numbers import numbers
from ulna.collision.scene_file import load_world
from ulna.collision.world import World
from ulna.errors import InputError
from ulna.robot import Robot, load
from ulna.robot.coordinates import coordinates_of

RobotName = Annotated[str, typer.Argument(metavar="ROBOT", help="A bundled name, or the path of a .urdf or .xacro file.")]
XacroArgs = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="KEY:=VALUE", help="An argument of a xacro file; repeatable.")
]
PackageDirs = Annotated[
    list[Path] | None, typer.Option("--package-dir", metavar="FOLDER", help="A folder that holds ROS packages; repeatable.")
]
Link = Annotated[str | None, typer.Option(metavar="NAME", help="The link; the tip unless given.")]
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
    """Around a call of the library: an ``InputError`` names the option instead of the argument.

    Args:
        names: The option of each argument, as in ``{"host": "--host"}``.

    Raises:
        InputError: The library has refused an argument.
    """
    try:
        yield
    except InputError as error:
        raise InputError(names.get(error.argument, error.argument), error.message) from None


def load_robot(robot: str, xacro_arg: Sequence[str] | None, package_dir: Sequence[Path] | None) -> Robot:
    """The robot that the options name.

    Raises:
        UlnaError: It cannot be loaded; see ``ulna.load``.
    """
    return load(robot, xacro_args=xacro_arguments(xacro_arg), package_dirs=package_dir or ())


def xacro_arguments(xacro_arg: Sequence[str] | None) -> dict[str, str]:
    """The arguments of a xacro file, from key:=value.

    Raises:
        InputError: One of them is not written so.
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
