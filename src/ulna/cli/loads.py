"""Reads the payload of an arm and the limits of its motors: ``--payload``, ``--effort``, ``--torque``."""

from typing import Annotated, NamedTuple

import numpy as np
import typer
from numpy.typing import ArrayLike, NDArray

from ulna.cli.depends import Depends
from ulna.cli.mount import FreeFall, mounted
from ulna.cli.targets import XYZ, numbers, words
from ulna.description.pose import pose
from ulna.description.shapes import Sphere
from ulna.dynamics.effort import known_limits, without_limit
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate, coordinates_of

Array = NDArray[np.float64]
PayloadText = Annotated[
    str | None,
    typer.Option(
        "--payload", metavar="MASS@X,Y,Z", help="A part, as 3kg@0,0,0.1: its mass, and its center in the frame of --link."
    ),
]
Effort = Annotated[
    str | None,
    typer.Option(metavar="NUMBERS", help="Limits in Nm or N, one or one for each joint, in place of the description's."),
]
Torque = Annotated[
    bool, typer.Option("--torque", help="Keep the description's effort limits during the motion; --effort sets others.")
]
_NAME = "--payload"  # name of the payload among the robot's attached objects


class Loads(NamedTuple):
    """The payload, gravity and torque limits of a motion, as the options give them."""

    free_fall: Array | None
    torque: bool
    effort: str | None
    payload: str | None

    def on(self, robot: Robot, link: str | None) -> Robot:
        """The robot as it is mounted, with the payload in its hand.

        Raises:
            InputError: A payload or a mounting is given without torque limits, and so has no effect.
        """
        if not self.torque and self.effort is None and (self.payload is not None or self.free_fall is not None):
            raise InputError(
                "--payload, --mount, --gravity", "require --torque or --effort: without a torque limit they have no effect"
            )
        robot = mounted(robot, self.free_fall)
        return robot if self.payload is None else holding(robot, *payload_of(self.payload), link)

    def limits(self, robot: Robot) -> ArrayLike | None:
        """The torque limits for a trajectory; None without an option."""
        return self.torque or None if self.effort is None else effort_limits(robot, self.effort)[1]


def loads_of(free_fall: FreeFall, *, torque: Torque = False, effort: Effort = None, payload: PayloadText = None) -> Loads:
    """Collect the options of the motors."""
    return Loads(free_fall, torque, effort, payload)


MotorLoads = Annotated[Loads, Depends(loads_of)]


def holding(robot: Robot, mass: float, center: ArrayLike, link: str | None) -> Robot:
    """The robot with a mass [kg] at a point of a link, shape (3,) [m]; it collides with no link."""
    names = *robot.link_names, *(one.name for one in robot.attached)
    return robot.with_attached(_NAME, Sphere(0.0), pose(center), link=link, touch_links=names, mass=mass)


def payload_of(text: str | None) -> tuple[float, list[float]]:
    """Parse "3kg@0,0,0.1" into mass [kg] and center [m]; without a text a mass of 0 at the origin."""
    if text is None:
        return 0.0, [0.0, 0.0, 0.0]
    mass, at, place = text.partition("@")
    (weight,) = numbers("--payload", mass.strip().removesuffix("kg"), [Coordinate("mass in kg", "kg")])
    if weight < 0.0:
        raise InputError("--payload", f"{text!r}; a mass of at least 0 is expected, as 3kg@0,0,0.1")
    return weight, numbers("--payload", place, XYZ) if at else [0.0, 0.0, 0.0]


def effort_limits(robot: Robot, effort: str | None) -> tuple[tuple[str, ...], Array]:
    """The names of joints without a known limit, and all limits, infinite for those joints."""
    if effort is None:
        return without_limit(robot.tree), known_limits(robot.tree)
    names = [each.name for each in coordinates_of(robot)]
    one = len(words(effort)) == 1
    given = numbers("--effort", effort, [Coordinate(name, "") for name in (["all joints"] if one else names)])
    if min(given, default=1.0) <= 0.0:
        raise InputError("--effort", f"{min(given):g}; limits above 0 are expected")
    return (), np.broadcast_to(given, robot.n_dof).astype(np.float64)
