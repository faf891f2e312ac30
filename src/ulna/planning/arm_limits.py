"""Lists limits of velocity, acceleration and jerk of some arms, from their documentation or source code.

All figures here and in the tables of arms are from a source. A limit without a source is None: the caller has to give it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.names.arm_tables import ArmTable, arm_tables

Array = NDArray[np.float64]


class ArmLimits(NamedTuple):
    """The limits of an arm's joints from a source, shape (n_dof,) each; None if the source has no such limits.

    Attributes:
        velocity: Maximum velocity of each joint [rad/s or m/s]; NaN for a joint without one.
        acceleration: Maximum acceleration [rad/s^2 or m/s^2].
        jerk: Maximum jerk [rad/s^3 or m/s^3].
        source: The source of the figures.
        lower: Minimum position of each joint [rad or m]; -inf for a joint without one.
        upper: Maximum position of each joint [rad or m]; inf for a joint without one.
        scaling: The default scaling factors of velocity and acceleration for motions.
        near_ends: Position-dependent velocity limits: rows (offset, rate, lower, upper), shape (n_dof, 4). The maximum velocity
            towards the upper end is sqrt(rate (upper - q)) - offset, towards the lower end sqrt(rate (q - lower)) - offset.
    """

    velocity: Array
    acceleration: Array | None
    jerk: Array | None
    source: str
    near_ends: Array | None = None
    lower: Array | None = None
    upper: Array | None = None
    scaling: tuple[float, float] = (1.0, 1.0)

    def velocity_at(self, q: Array, qd: Array) -> Array:
        """The maximum velocity [rad/s or m/s] at positions q in the direction of velocities qd, shape (..., n_dof) each."""
        most = np.broadcast_to(self.velocity, q.shape)
        if self.near_ends is None:
            return most
        offset, rate, lower, upper = self.near_ends.T
        left = np.where(qd > 0.0, upper - q, q - lower)
        return np.minimum(most, np.maximum(0.0, np.sqrt(np.maximum(0.0, rate * left)) - offset))


def _numbers(*values: float) -> Array:
    array = np.array(values)
    array.setflags(write=False)
    return array


_FR3_NEAR_ENDS = np.array(
    [
        (0.301, 12.0, -2.7501, 2.7501),
        (0.201, 5.17, -1.7918, 1.7918),
        (0.201, 7.00, -2.9065, 2.9065),
        (0.301, 8.00, -3.0481, -0.1458),
        (0.351, 34.0, -2.8101, 2.8101),
        (0.351, 11.0, 0.54092, 4.5205),
        (0.351, 34.0, -3.0196, 3.0196),
    ]
)

ARMS = {
    "panda": ArmLimits(
        _numbers(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        _numbers(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        _numbers(7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0),
        "libfranka 0.9.2, include/franka/rate_limiting.h, before its margins for lost packets",
    ),
    "fr3": ArmLimits(
        _numbers(2.619, 2.619, 2.619, 2.619, 5.259, 4.179, 5.259),
        _numbers(*[10.0] * 7),
        _numbers(*[5000.0] * 7),
        "libfranka, include/franka/rate_limiting.h at 155ddac8, with its margin of 0.001 rad/s",
        _FR3_NEAR_ENDS,
    ),
}


def _of_table(arm: ArmTable) -> ArmLimits:
    """The limits of an arm from its table, without positions, which are in its description."""
    velocity = _numbers(*(arm.radians(row.velocity) for row in arm.moving))
    acceleration = _numbers(*(arm.radians(row.acceleration) for row in arm.moving))
    return ArmLimits(velocity, acceleration if np.isfinite(acceleration).all() else None, None, arm.limits_from)


ARMS.update({name: _of_table(arm) for arm in arm_tables().values() for name in (arm.name, *arm.also)})
