"""Lists every whole turn of solutions that the joint limits allow."""

from collections.abc import Iterator
from itertools import product
from math import prod

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.ik.turns import TURN

Array = NDArray[np.float64]
_MOST = 1_000_000  # configurations of one solution: 50 MB


def every_turn(q: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """One configuration (n_dof,) within the limits with all whole turns that stay within them, itself first, (k, n_dof).

    Joints without limits on both sides make no turns.

    Raises:
        InputError: There are more than a million of them.
    """
    places = [list(_turns_of(*joint)) for joint in zip(q, lower, upper, turning, strict=True)]
    n = prod(map(len, places))
    if n > _MOST:
        raise InputError("whole_turns", f"the limits allow {n:,} turns of one solution; {_MOST:,} are listed at most")
    return np.array(list(product(*places)))


def _turns_of(x: float, lower: float, upper: float, turns: bool) -> Iterator[float]:  # noqa: FBT001 - one of a row of arrays
    yield x
    if not turns or not np.isfinite(lower) or not np.isfinite(upper):
        return
    for k in range(int(np.ceil((lower - x) / TURN)), int(np.floor((upper - x) / TURN)) + 1):
        if k:
            yield x + k * TURN
