"""Adds whole turns to entries of q where no pose changes, to come near another q."""

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, FIXED, KIND, RATIO, REVOLUTE

Array = NDArray[np.float64]
TURN = 2 * np.pi


def turning_columns(chain: Array, n_dof: int) -> NDArray[np.bool_]:
    """The entries of q that drive revolute joints at ratio 1 or -1 alone: a whole turn of one changes nothing."""
    turning = np.ones(n_dof, dtype=bool)
    for row in chain:
        if int(row[KIND]) != FIXED and (int(row[KIND]) != REVOLUTE or abs(row[RATIO]) != 1.0):
            turning[int(row[COLUMN])] = False
    return turning


def nearest_turns(q: Array, goal: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """q (..., n_dof) with each of the turning entries as near to ``goal`` as whole turns bring it between the bounds."""
    with np.errstate(invalid="ignore"):
        near = q - TURN * np.rint((q - goal) / TURN)
        near = near + TURN * np.ceil(np.maximum(lower - near, 0.0) / TURN)
        near = near - TURN * np.ceil(np.maximum(near - upper, 0.0) / TURN)
    return np.where(turning & (near >= lower) & (near <= upper), near, q)
