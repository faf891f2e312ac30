"""Adds whole turns to entries of q, which change no pose: towards another q, or all within the limits."""

from collections.abc import Iterator
from itertools import product
from math import prod

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.kernels.chain.closed_form_layout import AT_LIMIT
from ulna.kernels.layout import COLUMN, FIXED, KIND, RATIO, REVOLUTE

Array = NDArray[np.float64]
TURN = 2 * np.pi
_MAX_LISTED = 1_000_000  # configurations of one solution: 50 MB


def turning_columns(chain: Array, n_dof: int) -> NDArray[np.bool_]:
    """Mask of the entries of q that drive only revolute joints at ratio 1 or -1.

    A whole turn of such an entry changes no pose.
    """
    turning = np.ones(n_dof, dtype=bool)
    for row in chain:
        if int(row[KIND]) != FIXED and (int(row[KIND]) != REVOLUTE or abs(row[RATIO]) != 1.0):
            turning[int(row[COLUMN])] = False
    return turning


def nearest_turns(q: Array, goal: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """q (..., n_dof) with whole turns added that bring each turning entry nearest to ``goal`` within the bounds."""
    with np.errstate(invalid="ignore"):
        nearest = q - TURN * np.rint((q - goal) / TURN)
        nearest = nearest + TURN * np.ceil(np.maximum(lower - nearest, 0.0) / TURN)
        nearest = nearest - TURN * np.ceil(np.maximum(nearest - upper, 0.0) / TURN)
    return np.where(turning & (nearest >= lower) & (nearest <= upper), nearest, q)


def turn_towards_middle(q: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """q (..., n_dof) with whole turns added that bring each turning entry nearest to the middle of its range."""
    with np.errstate(invalid="ignore"):  # of joints without limits
        middle = np.where(np.isfinite(lower) & np.isfinite(upper), (lower + upper) / 2, q)
    return np.where(turning, q - TURN * np.rint((q - middle) / TURN), q)


def all_turns(q: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """All configurations that differ from one (n_dof,) by whole turns and stay within the limits, (k, n_dof).

    The given one comes first. Joints without limits on both sides make no turns. A configuration at a limit up to rounding is put
    exactly at the limit.
    """
    positions = [list(_turns_of(*joint)) for joint in zip(q, lower, upper, turning, strict=True)]
    n = prod(map(len, positions))
    if n > _MAX_LISTED:
        raise InputError("whole_turns", f"the limits allow {n:,} turns of one solution; {_MAX_LISTED:,} are listed at most")
    return np.array(list(product(*positions)))


def _turns_of(x: float, lower: float, upper: float, turns: bool) -> Iterator[float]:  # noqa: FBT001 - one of a row of arrays
    yield x
    if not turns or not np.isfinite(lower) or not np.isfinite(upper):
        return
    first, last = np.ceil((lower - AT_LIMIT - x) / TURN), np.floor((upper + AT_LIMIT - x) / TURN)
    for k in range(int(first), int(last) + 1):
        if k:
            yield min(max(x + k * TURN, lower), upper)
