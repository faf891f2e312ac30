"""Copies an object's pose if it is an exact rigid motion; otherwise writes nothing and returns False."""

from ulna.engine.decorators import low_latency_entry
from ulna.engine.signatures import MATRIX
from ulna.kernels.layout import EXACT_DEFECT
from ulna.kernels.spatial.se3 import rigidity_defect


@low_latency_entry((MATRIX, MATRIX))
def copy_exact(T, out):
    """Copy a pose to out, shape (4, 4) each.

    Returns False, and writes nothing, if it is no rigid motion up to rounding.
    """
    if not rigidity_defect(T) < EXACT_DEFECT:
        return False
    for r in range(3):
        for c in range(4):
            out[r, c] = T[r, c]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0
    return True
