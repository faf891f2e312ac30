"""What the subcommands' options have in common, and what they mean."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

import ulna
from ulna.cli.numbers import numbers
from ulna.errors import InputError
from ulna.robot.coordinates import coordinates_of

RobotName = Annotated[str, typer.Argument(metavar="ROBOT", help="A bundled name, or the path of a .urdf or .xacro file.")]
XacroArgs = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="KEY:=VALUE", help="An argument of a xacro file; repeatable.")
]
PackageDirs = Annotated[
    list[Path] | None, typer.Option("--package-dir", metavar="FOLDER", help="Where ROS packages lie; repeatable.")
]
Link = Annotated[str | None, typer.Option(metavar="NAME", help="The link; the tip unless given.")]
Positions = Annotated[
    str | None, typer.Option("--q", metavar="NUMBERS", help='Joint positions, as in "0,-pi/4,0.5 1e-3"; home unless given.')
]
Degrees = Annotated[bool, typer.Option("--degrees", help="All angles given are degrees, not radians.")]
Scene = Annotated[Path | None, typer.Option(metavar="FILE", help="A scene file: the obstacles, as `ulna view` saves them.")]
Hulls = Annotated[bool, typer.Option("--hulls", help="Take the convex hulls of meshes as the robot's shapes.")]
NoOpen = Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")]
SERVED = {"host": "--host", "port": "--port"}  # what a page is opened with, by the names of its options
Json = Annotated[bool, typer.Option("--json", help="One JSON object instead of tables: metres and radians, infinity is null.")]


@contextmanager
def as_options(names: Mapping[str, str]) -> Iterator[None]:
    """Around a call of the library: what it refuses is told by the name of the option, not by that of the argument."""
    try:
        yield
    except InputError as error:
        raise InputError(names.get(error.argument, error.argument), error.message) from None


def load_robot(robot: str, xacro_arg: Sequence[str] | None, package_dir: Sequence[Path] | None) -> ulna.Robot:
    """The robot that the options name."""
    return ulna.load(robot, xacro_args=xacro_arguments(xacro_arg), package_dirs=package_dir or ())


def xacro_arguments(xacro_arg: Sequence[str] | None) -> dict[str, str]:
    """The arguments of a xacro file, from key:=value."""
    arguments = {}
    for text in xacro_arg or ():
        key, separator, value = text.partition(":=")
        if not (separator and key):
            raise InputError("--xacro-arg", f"{text!r}; key:=value is expected")
        arguments[key] = value
    return arguments


def load_scene(path: Path | None) -> ulna.World:
    """The world of a scene file; an empty one without it."""
    return ulna.World() if path is None else ulna.load_world(path)


def positions(option: str, text: str | None, robot: ulna.Robot, *, degrees: bool) -> NDArray[np.float64]:
    """One q, shape (n_dof,): the numbers of an option, or home without it."""
    if text is None:
        return robot.home
    return np.array(numbers(option, text, coordinates_of(robot), degrees=degrees))
