"""Samples a motion as curves: positions, velocities, accelerations and jerks, with their limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot

Array = NDArray[np.float64]
QUANTITIES = ("position", "velocity", "acceleration", "jerk")
_SAMPLES = 400


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity of a motion over time.

    Attributes:
        t: Times [s], shape (n,).
        values: The quantity of each entry of q, in radians or metres and seconds, shape (n, n_dof).
        low, high: Its limits, shape (n_dof,) each; infinite where there are none.
    """

    t: Array
    values: Array
    low: Array
    high: Array

    @property
    def shares(self) -> Array:
        """The values from -1 at the lower limit to 1 at the upper one, shape (n, n_dof); NaN where there are no limits."""
        with np.errstate(invalid="ignore", divide="ignore"):
            middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2
            return np.where(np.isfinite(half) & (half > 0.0), (self.values - middle) / half, np.nan)


def curves_of(robot: Robot, motion: Trajectory, velocity: Array, acceleration: float, jerk: float | None) -> dict[str, Curve]:
    """The curves of a motion by quantity; no jerk if it is not limited: then the acceleration has jumps.

    Args:
        robot: The robot.
        motion: The motion.
        velocity: The limits [rad/s or m/s] with which it was made, shape (n_dof,).
        acceleration: That of every joint [rad/s^2 or m/s^2].
        jerk: That of every joint [rad/s^3 or m/s^3]; None for no limit.
    """
    t = np.linspace(0.0, motion.duration, _SAMPLES)
    most = [np.broadcast_to(limit, velocity.shape) for limit in (velocity, acceleration, jerk) if limit is not None]
    ends = [(robot.lower, robot.upper), *((-limit, limit) for limit in most)]
    return {name: Curve(t, values, *end) for name, values, end in zip(QUANTITIES, motion.at(t), ends, strict=False)}
