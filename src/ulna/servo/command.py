"""Holds what a tick of a servo commands, and says what limits it."""

from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class CommandStatus(StrEnum):
    """What a tick of a servo was."""

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
    """What limits a command.

    Attributes:
        joint: The entry of q that is at a limit, or farthest off its command, by its joint's name; None if none is.
        pair: The names of the two shapes, or of a shape and an object, that are near; None if none are.
        distance: Of that pair, where the certified stop ended before this tick, or in collision where the arm was [m]; None
            without one.
        share: How much of the way from the certified stop's velocity to the velocity found was certified, 0 to 1.
        too_fast: An object that moved faster than its stated speed before this tick; None if none did.
        bounded: Whether so many solids are near a shape that only some were measured, and the others bounded: as where a cloud
            holds points of the arm itself. What was certified is certified all the same; the arm may move less than it could.
    """

    joint: str | None
    pair: tuple[str, str] | None
    distance: float | None
    share: float
    too_fast: str | None
    bounded: bool


class Command(NamedTuple):
    """What a tick of a servo commands: the state at the end of the tick, to be reached with constant acceleration.

    Of a servo with a limit of jerk it is to be reached with constant jerk.

    Attributes:
        q: Joint positions [rad or m], shape (n_dof,).
        qd: Joint velocities [rad/s or m/s], shape (n_dof,).
        qdd: Joint accelerations in the tick [rad/s^2 or m/s^2], shape (n_dof,); with a limit of jerk those at its end.
        status: What the tick was.
        limiting: What limits it.
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
"""By the numbers of ``servo_records``, in their order."""
