"""What a search for a configuration found, or how near it came."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class Status(StrEnum):
    """How a search ended."""

    SOLVED = "solved"
    NOT_FOUND = "not found"
    STATIONARY = "stationary"


@dataclass(frozen=True, eq=False)
class IKResult:
    """Configurations for targets of shape (..., 4, 4).

    For a batch every field is an array of its shape (...,), and ``q`` has one axis more; for one target plain values.

    Not finding a configuration is a result too: then ``success`` is False and ``q`` the best one met, within the limits.

    Attributes:
        q: Joint positions [rad or m], shape (..., n_dof), always within the limits.
        success: Whether both errors are within the tolerances.
        status: "solved"; "not found" (the budget is spent); "stationary" (steepest descent came to rest short of the target).
        position_error: Distance of the link's origin from the target's [m], by forward kinematics of ``q``.
        rotation_error: Angle of the rotation that is left [rad].
        iterations: Steps taken.
        tolerances: Those asked for [m, rad].
    """

    q: NDArray[np.float64]
    success: bool | NDArray[np.bool_]
    status: Status | NDArray[np.str_]
    position_error: float | NDArray[np.float64]
    rotation_error: float | NDArray[np.float64]
    iterations: int | NDArray[np.int64]
    tolerances: tuple[float, float]

    def __str__(self) -> str:
        if np.ndim(self.success) == 0:
            off = f"{self.position_error * 1e3:.3g} mm and {np.degrees(self.rotation_error):.3g} deg from the target"
            return f"{self.status}: {off} after {self.iterations} steps"
        solved = int(np.count_nonzero(self.success))
        worst = [f"{np.max(errors, initial=0.0):.3g}" for errors in (self.position_error, self.rotation_error)]
        return f"{solved} of {np.size(self.success)} targets solved; largest errors {worst[0]} m, {worst[1]} rad"
