"""Defines the records of a path's constraints and of its configuration space."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record, Records

NO_AXIS, Z_AXIS, ALL_AXES, TOWARDS = 0, 1, 2, 3  # the compared axes; TOWARDS: z points towards the other frame's origin
MIN_LENGTH = 1e-30  # [m]: minimum divisor


class Constraint(Record):
    """The tolerances of one constraint on a frame of the robot relative to another frame."""

    away: Annotated[NDArray[np.float64], 3]
    """Tolerance of the origin along each axis of the other frame [m]; infinite where it is free."""
    axes: int
    """The compared axes: NO_AXIS, Z_AXIS, ALL_AXES or TOWARDS."""
    chord: float
    """The maximum length of the difference of the compared axes."""
    lever: float
    """The distance of the frame's origin from its joint's origin [m]."""
    shared: int
    """The last joint that carries both frames, or BASE."""
    is_pointing: bool
    """Whether the projection compares only the swing of the z axis (``kernels.ik.task_error``)."""
    slack: Annotated[NDArray[np.float64], 6]
    """Tolerance of each component of the error in the projection [m, rad]."""


# Entries take it as one argument.
class Constraints(NamedTuple):
    """The constraints of a path."""

    frames: NDArray
    """Two rows per constraint: its frame, and the other frame, of the base or the robot, shape (2 n, FRAME_WIDTH)."""
    allowed: Records[Constraint]
    """The tolerances, shape (n,)."""


class Entry(Record):
    """One entry of q in the configuration space of a plan."""

    low: float
    """The minimum of samples [rad or m]."""
    high: float
    """The maximum of samples [rad or m]."""
    weight: float
    """The weight in the metric of the space."""
    period: float
    """The whole turn of an angle without limits [rad]; else 0."""
