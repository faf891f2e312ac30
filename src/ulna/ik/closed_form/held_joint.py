"""Moves targets instead of a held joint at either end of a chain: so one form serves all its places."""

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.kernels.layout import COLUMN, FIXED, KIND, OFFSET, RATIO
from ulna.kinematics.tree import motion_along_z, row_pose

Array = NDArray[np.float64]


def targets_with_held_at_zero(chain: Array, column: int, targets: Array, places: Array) -> Array | None:
    """Targets (n, 4, 4) for the held joint at its places (n,), moved so that it is at 0; None where it is at neither end.

    1. The last joint: T = A M(x) B, so A M(0) B = T B^-1 M(x)^-1 M(0) B.
    2. The first joint: T = A M(x) B, so A M(0) B = A M(0) M(x)^-1 A^-1 T.
    """
    moving = [i for i, row in enumerate(chain) if int(row[KIND]) != FIXED and row[RATIO] != 0.0]
    own = [i for i in moving if int(chain[i][COLUMN]) == column]
    if len(own) != 1 or own[0] not in {moving[0], moving[-1]}:
        return None
    row = chain[own[0]]
    zero, motion = (motion_along_z(int(row[KIND]), row[RATIO] * x + row[OFFSET]) for x in (0.0, places))
    back = inverse(motion)
    if own[0] == moving[-1]:
        behind = _product(chain[own[0] + 1 :])
        return targets @ inverse(behind) @ back @ (zero @ behind)
    before = _product(chain[: own[0] + 1])
    return (before @ zero) @ back @ inverse(before) @ targets


def _product(rows: Array) -> Array:
    """The pose of rows that do not move."""
    T = np.eye(4)
    for row in rows:
        T = T @ row_pose(row)
    return T
