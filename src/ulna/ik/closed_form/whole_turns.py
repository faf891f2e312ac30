"""Lists every whole turn of solutions that the joint limits allow. Used by ``closed_form.solutions``."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ulna.ik.turns import TURN

Array = NDArray[np.float64]


def every_turn(q: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]) -> Array:
    """One configuration (n_dof,) within the limits with all whole turns that stay within them, itself first, (k, n_dof).

    Joints without limits on both sides make no turns.
    """
    places = [list(_turns_of(*joint)) for joint in zip(q, lower, upper, turning, strict=True)]
    return np.array(list(product(*places)))


def _turns_of(x: float, lower: float, upper: float, turns: bool) -> Iterator[float]:  # noqa: FBT001 - one of a row of arrays
    yield x
    if not turns or not np.isfinite(lower) or not np.isfinite(upper):
        return
    for k in range(int(np.ceil((lower - x) / TURN)), int(np.floor((upper - x) / TURN)) + 1):
        if k:
            yield x + k * TURN
