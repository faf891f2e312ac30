"""Reads the mounting of a robot: ``--mount``, ``--gravity``."""

from enum import StrEnum
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.cli.depends import Depends
from ulna.cli.targets import numbers
from ulna.dynamics.dynamics import FREE_FALL
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate

_G = -float(FREE_FALL[2])  # [m/s^2]
_AXES = tuple(Coordinate(name, "m/s^2") for name in "xyz")


class Mounting(StrEnum):
    """The surface that carries the base of a robot."""

    FLOOR = "floor"
    WALL = "wall"
    CEILING = "ceiling"


_FREE_FALL = {Mounting.FLOOR: (0.0, 0.0, -_G), Mounting.WALL: (_G, 0.0, 0.0), Mounting.CEILING: (0.0, 0.0, _G)}

Mount = Annotated[
    Mounting | None,
    typer.Option("--mount", help="floor; wall: the x axis of the base points down; or ceiling. By default the floor."),
]
Gravity = Annotated[
    str | None,
    typer.Option(
        "--gravity", metavar="X,Y,Z", help="Or the acceleration of free fall in the axes of the base, in m/s^2, as 0,0,-9.81."
    ),
]


def free_fall_of(*, mount: Mount = None, gravity: Gravity = None) -> NDArray[np.float64] | None:
    """The acceleration of free fall of ``--mount`` or ``--gravity`` [m/s^2], shape (3,); None without them."""
    if mount is not None and gravity is not None:
        raise InputError("--mount, --gravity", "give only one of them")
    if gravity is not None:
        return np.array(numbers("--gravity", gravity, _AXES))
    return None if mount is None else np.array(_FREE_FALL[mount])


FreeFall = Annotated[NDArray[np.float64] | None, Depends(free_fall_of)]


def mounted(robot: Robot, free_fall: NDArray[np.float64] | None) -> Robot:
    """The robot as it is mounted; unchanged without an option."""
    return robot if free_fall is None else robot.with_gravity(free_fall)
