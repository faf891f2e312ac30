"""Names what a path keeps at all times, and in which space it is searched for."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import Record, Records

NO_AXIS, Z_AXIS, ALL_AXES, TOWARDS = 0, 1, 2, 3  # which axes are compared, or that z points towards the other frame's origin
MIN_LENGTH = 1e-30  # [m]: by which is divided


class Constraint(Record):
    """One constraint: how a frame of the robot may lie, seen from another frame."""

    away: Annotated[NDArray[np.float64], 3]
    """Tolerance of its origin along each axis of the other frame, infinite where it is free [m]."""
    axes: int
    """NO_AXIS, Z_AXIS, ALL_AXES or TOWARDS."""
    chord: float
    """The greatest length of the difference of the axes that are compared."""
    lever: float
    """Distance of its origin from the joint's [m]."""
    shared: int
    """The last joint that carries both frames, or BASE."""
    is_pointing: bool
    """Whether its projection compares the swing of the z axis alone (``kernels.ik.task_error``)."""
    slack: Annotated[NDArray[np.float64], 6]
    """Tolerance of each component of the error in its projection [m, rad]."""


# An entry takes it whole.
class Constraints(NamedTuple):
    """The constraints of a path."""

    frames: NDArray
    """Two rows a constraint, its frame and the other one, of the base or of the robot, shape (2 n, FRAME_WIDTH)."""
    allowed: Records[Constraint]
    """Shape (n,)."""


class Entry(Record):
    """One entry of q in the space of a plan."""

    low: float
    """From here to ``high`` samples are taken [rad or m]."""
    high: float
    weight: float
    """Weight in the metric of the space."""
    period: float
    """The whole turn of an entry that may turn for ever [rad], else 0."""
