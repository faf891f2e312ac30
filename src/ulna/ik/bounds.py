"""Narrows the bounds of a search for one call: joints that are held, and steps no longer than allowed."""

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError

Array = NDArray[np.float64]


def narrowed(limits: Array, seeds: Array, held: tuple[int, ...], max_step: float) -> Array:
    """The bounds of a search, shape (1 or n_seeds, 4, n_dof): the limits, less what is held or too far from the seed.

    Args:
        limits: Lower and upper limits and the usual range, shape (1, 4, n_dof).
        seeds: [rad or m], shape (n_seeds, n_dof).
        held: The columns of q that stay at the seed.
        max_step: The most that a column may differ from the seed [rad or m].

    Raises:
        InputError: A seed is so far beyond the limits that nothing is left.
    """
    if not held and np.isinf(max_step):
        return limits
    reach = np.full(limits.shape[-1], max_step)
    reach[list(held)] = 0.0
    lower, upper = np.maximum(limits[:, 0], seeds - reach), np.minimum(limits[:, 1], seeds + reach)
    beyond = np.argwhere(lower > upper)
    if len(beyond):
        what = "a joint that is held" if reach[beyond[0][1]] == 0.0 else "a joint"
        raise InputError("q_seed", f"{what} is further beyond its limits than it may move (entry {beyond[0][1]} of q)")
    low, high = np.clip(limits[:, 2], lower, upper), np.clip(limits[:, 3], lower, upper)
    return np.stack([lower, upper, low, high], axis=1)
