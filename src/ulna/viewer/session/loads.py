"""Computes the holding torques of a robot at rest, and their shares of the effort limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.dynamics.effort import known_limits
from ulna.errors import InertiaError
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

TORQUES = "holding torques"
NEAR_LIMIT = 0.8  # share of the effort limit from which a joint is marked as near it


@dataclass(frozen=True)
class Load:
    """The holding torque or force of one joint.

    Attributes:
        torque: The torque or force, in its unit.
        limit: The effort limit; infinite if none is known.
        unit: Nm or N.
    """

    torque: float
    limit: float
    unit: str

    @property
    def share(self) -> float:
        """The absolute torque divided by its limit; 0 if no limit is known."""
        return abs(self.torque) / self.limit

    def __str__(self) -> str:
        if np.isinf(self.limit):
            return f"{abs(self.torque):.1f} {self.unit}, no limit known"
        return f"{abs(self.torque):.1f} of {self.limit:g} {self.unit}"


def loads(robot: Robot, q: NDArray[np.float64]) -> tuple[Load, ...]:
    """The load of each entry of q at rest, with attached objects and the robot's own gravity."""
    units = (entry.effort_unit for entry in coordinates_of(robot))
    values = (robot.gravity_torque(q) + 0.0).tolist(), known_limits(robot.tree).tolist(), units
    return tuple(Load(*each) for each in zip(*values, strict=True))


def has_inertias(robot: Robot) -> bool:
    """Whether the torques can be computed: every moving link with a shape has an inertia, and there is a mass."""
    try:
        robot.inertial_parameters  # noqa: B018 - raises InertiaError
    except InertiaError:
        return False
    return robot.n_dof > 0
