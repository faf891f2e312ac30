"""Computes the torques that hold a robot still, as shares of the limits of effort."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.dynamics.effort import known_limits
from ulna.errors import InertiaError
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

TORQUES = "the torques at rest"
NEAR = 0.8  # of a limit: from here on a joint is shown as one that soon limits the robot


@dataclass(frozen=True)
class Load:
    """The torque of one joint at rest.

    Attributes:
        torque: The torque, in its unit.
        limit: The limit of effort; infinite where none is known.
        unit: Nm or N.
    """

    torque: float
    limit: float
    unit: str

    @property
    def share(self) -> float:
        """The torque without its sign, by its limit; 0 where none is known."""
        return abs(self.torque) / self.limit

    def __str__(self) -> str:
        if np.isinf(self.limit):
            return f"{abs(self.torque):.1f} {self.unit}, no limit known"
        return f"{abs(self.torque):.1f} of {self.limit:g} {self.unit}"


def loads(robot: Robot, q: NDArray[np.float64]) -> tuple[Load, ...]:
    """The load of each entry of q, with what the robot holds and in its own gravity."""
    units = (entry.effort_unit for entry in coordinates_of(robot))
    values = (robot.gravity_torque(q) + 0.0).tolist(), known_limits(robot.tree).tolist(), units
    return tuple(Load(*each) for each in zip(*values, strict=True))


def are_known(robot: Robot) -> bool:
    """Whether all links that move and have a shape have an inertia, and some link moves a mass."""
    try:
        robot.inertial_parameters  # noqa: B018 - it is kept
    except InertiaError:
        return False
    return robot.n_dof > 0
