"""Times a line from rest to rest within limits of velocity, acceleration and jerk.

Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 3.4: the velocity has the
form of two S. The jerk is constant in each of seven phases.
"""

import math

import numpy as np
from numpy.typing import NDArray

N_PHASES = 7


def double_s(length: float, velocity: float, acceleration: float, jerk: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The durations [s] of the seven phases of the fastest motion over a length, and the jerk in each."""
    peak, top = velocity, acceleration
    if peak * jerk < top * top:  # the velocity is reached before the acceleration
        top = math.sqrt(peak * jerk)
    if peak * (peak / top + top / jerk) > length:  # the velocity is not reached
        peak = 0.5 * acceleration * (math.sqrt((acceleration / jerk) ** 2 + 4 * length / acceleration) - acceleration / jerk)
        top = acceleration
        if peak * jerk < top * top:
            peak = (0.25 * length * length * jerk) ** (1 / 3)
            top = math.sqrt(peak * jerk)
    bending, steady = top / jerk, max(peak / top - top / jerk, 0.0)
    cruise = max(length / peak - (steady + 2 * bending), 0.0)
    durations = np.array([bending, steady, bending, cruise, bending, steady, bending])
    return durations, jerk * np.array([1.0, 0, -1, 0, -1, 0, 1])
