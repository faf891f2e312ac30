"""Matrices that are no poses, each with the fault that an error must name."""

import numpy as np

import ulna

TARGET = ulna.pose((0.4, 0.1, 0.5), (3.0, 0.1, 0.2))


def spoilt(*changes):
    """The target with entries ((row, column), value) put in."""
    T = TARGET.copy()
    for entry, value in changes:
        T[entry] = value
    return T


def mirrored():
    return TARGET @ np.diag([1.0, 1, -1, 1])


INVALID_POSES = {
    "nan in the rotation": (spoilt(((0, 0), np.nan)), "has an entry that is not finite"),
    "nan in the position": (spoilt(((1, 3), np.nan)), "has an entry that is not finite"),
    "infinite position": (spoilt(((2, 3), np.inf)), "has an entry that is not finite"),
    "infinite rotation": (spoilt(((2, 1), -np.inf)), "has an entry that is not finite"),
    "nan in the last row": (spoilt(((3, 0), np.nan)), "has an entry that is not finite"),
    "huge rotation": (spoilt(((0, 0), 1e9)), "has a rotation part whose columns are not orthonormal"),
    "overflowing rotation": (spoilt(((0, 0), 1e300)), "has a rotation part whose columns are not orthonormal"),
    "scaled": (TARGET * [[2], [2], [2], [1]], "has a rotation part whose columns are not orthonormal"),
    "zeros": (np.zeros((4, 4)), "has a last row that is not (0, 0, 0, 1)"),
    "last row": (spoilt(((3, 3), 1.1)), "has a last row that is not (0, 0, 0, 1)"),
    "reflection": (mirrored(), "is a reflection: its determinant is negative"),
}
