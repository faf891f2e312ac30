"""Defines the size of a chain, to which length thresholds are relative."""

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, KIND, LARGEST, PRISMATIC, RATIO

Array = NDArray[np.float64]
_ROUNDING = 1e-9  # m: a shorter chain is the rounding of offsets
_SHARE = 1e-5  # of the longest stroke: a chain shorter than this share of it counts as rounding too


def length_of(chain: Array) -> float:
    """The sum of the lengths of all parts of a chain [m], with prismatic joints at 0."""
    return float(np.linalg.norm(chain[:, [3, 7, 11]], axis=1).sum())


def longest_slide(chain: Array, lower: Array, upper: Array) -> float:
    """The longest stroke of a chain's prismatic joints [m]; 1 m for an unlimited one, 0 without any."""
    rows = chain[chain[:, KIND] == PRISMATIC]
    columns = rows[:, COLUMN].astype(np.int64)
    limited = (np.abs(lower[columns]) <= LARGEST) & (np.abs(upper[columns]) <= LARGEST)
    strokes = np.subtract(upper[columns], lower[columns], out=np.ones(len(rows)), where=limited)
    return float(np.where(limited, np.abs(rows[:, RATIO]) * strokes, 1.0).max(initial=0.0))


def size_of(length: float, slide: float) -> float:
    """The size of a chain [m], from its length and its longest stroke; 1 m if both are negligible."""
    return length if length > max(_ROUNDING, _SHARE * slide) else slide or 1.0


def units_of(chain: Array, lower: Array, upper: Array) -> Array:
    """The unit of each entry of q (n_dof,): 1 for an angle, else the size of the chain [m]."""
    units, slides = np.ones(len(lower)), chain[:, KIND] == PRISMATIC
    units[chain[slides, COLUMN].astype(np.int64)] = size_of(length_of(chain), longest_slide(chain, lower, upper))
    return units
