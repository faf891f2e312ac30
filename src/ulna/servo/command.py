"""Defines the command of a servo's tick: the state to reach, its status, and the joint or object that limits it."""

from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class CommandStatus(StrEnum):
    """Status of a tick: whether the arm follows its goal, and if not, the kind of limit."""

    FOLLOWING = "following"
    LIMITED_BY_POSITION = "limited by position"
    LIMITED_BY_VELOCITY = "limited by velocity"
    LIMITED_BY_ACCELERATION = "limited by acceleration"
    LIMITED_BY_JERK = "limited by jerk"
    LIMITED_BY_CLEARANCE = "limited by clearance"
    NEAR_SINGULARITY = "near a singularity"
    BRAKING = "braking"
    AT_REST = "at rest"
    NOT_CERTIFIED = "not certified"
    IN_COLLISION = "in collision"
    OFF_COMMAND = "off the command"
    LIMITED_BY_TORQUE = "limited by torque"


class Limiting(NamedTuple):
    """Joint, pair of shapes or object that limits a command.

    Attributes:
        joint: Name of the joint that is at a limit, or farthest off its command; None if no joint limits the arm.
        pair: Names of two shapes, or of a shape and an object, that are near each other; None without such a pair.
        distance: Distance of this pair [m]; None without a pair. It is measured in the configuration in which the arm would
            have come to rest before this tick. In collision it is measured where the arm was.
        share: Share of the velocity change that was certified, 0 to 1. The change is that from the braking trajectory's
            velocity to the one that the quadratic program found.
        too_fast: Name of an object that moved faster than its stated speed before this tick; None without one.
        bounded: Whether only some of the solids near a shape were measured, and the others bounded. This happens where a cloud
            contains points of the arm itself. Certificates stay valid, but the arm may move less than it could.
    """

    joint: str | None
    pair: tuple[str, str] | None
    distance: float | None
    share: float
    too_fast: str | None
    bounded: bool


class Command(NamedTuple):
    """Command of a servo's tick: the state at the end of the tick.

    The arm reaches it with constant acceleration, or with constant jerk if the servo limits the jerk.

    Attributes:
        q: Joint positions [rad or m], shape (n_dof,).
        qd: Joint velocities [rad/s or m/s], shape (n_dof,).
        qdd: Joint accelerations during the tick [rad/s^2 or m/s^2], shape (n_dof,). With a limit of jerk: at its end.
        status: Status of the tick.
        limiting: Joint, pair or object that limits the arm.
    """

    q: Array
    qd: Array
    qdd: Array
    status: CommandStatus
    limiting: Limiting

    def __str__(self) -> str:
        of, (joint, pair, distance, _, too_fast, bounded) = "", self.limiting
        if joint is not None:
            of = f": {joint}"
        elif pair is not None:
            far = 1e3 * (distance or 0.0)
            of = f": {pair[0]} is {abs(far):.3g} mm {'from' if far > 0.0 else 'in'} {pair[1]}"
        more = f"; {too_fast} moved faster than stated" if too_fast else ""
        return f"{self.status}{of}{more}" + ("; too much is near to measure all of it" if bounded else "")


STATUS_OF = tuple(CommandStatus)
"""Statuses in the order of their numbers in ``servo_records``."""
