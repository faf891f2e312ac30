"""The option ``--meshes``: convex shapes in the place of a robot's collision meshes. Used by ``check`` and ``view``."""

from enum import StrEnum
from typing import Annotated

import typer

from ulna.description.meshes.hulls import in_place_of_meshes, n_collision_meshes
from ulna.errors import FileError, GeometryError, InputError, MissingExtraError
from ulna.robot import Robot

_ADVICE = (
    "--meshes hulls (pip install 'ulna[hulls]') or --meshes decompose (pip install 'ulna[decompose]') checks shapes like them"
)


class InPlace(StrEnum):
    """What is checked in the place of collision meshes."""

    HULLS = "hulls"
    DECOMPOSE = "decompose"
    NONE = "none"


Meshes = Annotated[
    InPlace | None,
    typer.Option(
        "--meshes",
        help="What is checked in place of collision meshes: their convex hulls, which fill hollows; a decomposition into convex "
        "pieces, which takes minutes once; or none. Hulls unless given, where the extra hulls is installed.",
    ),
]
Hulls = Annotated[bool, typer.Option("--hulls", help="The same as --meshes hulls.")]


def with_chosen_shapes(robot: Robot, meshes: InPlace | None, *, hulls: bool, quiet: bool = False) -> Robot:
    """The robot with its collision meshes converted as the options say; a line on standard error tells how.

    Args:
        robot: The robot.
        meshes: The option ``--meshes``.
        hulls: The option ``--hulls``.
        quiet: Do not print that line: the JSON object has it.

    Raises:
        InputError: ``--hulls`` is given together with another value of ``--meshes``.
        FileError: A mesh cannot be read.
        MissingExtraError: An extra that the options ask for is not installed.
    """
    if hulls and meshes not in (None, InPlace.HULLS):
        raise InputError("--hulls", f"is --meshes hulls, and --meshes {meshes} is given too")
    chosen = InPlace.HULLS if hulls or meshes is None else meshes
    if not n_collision_meshes(robot.description) or chosen is InPlace.NONE:
        return robot
    if chosen is InPlace.DECOMPOSE:
        typer.echo("decomposing meshes; each takes seconds to minutes, and is kept for the next time", err=True)
        shaped = robot.with_convex_pieces()
    else:
        shaped = robot.with_convex_hulls()
    if not quiet:
        typer.echo(in_place_of_meshes(shaped.description), err=True)
    return shaped


def with_shapes_if_any(robot: Robot, meshes: InPlace | None, *, hulls: bool) -> Robot:
    """As ``with_chosen_shapes``; but if no option was given and the meshes cannot be converted, it only prints the reason.

    Raises:
        InputError, FileError, MissingExtraError: As ``with_chosen_shapes``, if an option was given.
    """
    try:
        return with_chosen_shapes(robot, meshes, hulls=hulls)
    except (FileError, MissingExtraError) as error:
        if hulls or meshes is not None:
            raise
        typer.echo(f"collisions are not checked: {error}", err=True)
        return robot


def refuse_meshes(robot: Robot) -> None:
    """Refuse to check a robot whose collision shapes are meshes.

    Raises:
        GeometryError: It has collision meshes; the message names the options that convert them.
    """
    count = n_collision_meshes(robot.description)
    if count:
        raise GeometryError(f"{count} of its collision shapes are meshes, which are not checked as they are; {_ADVICE}")
