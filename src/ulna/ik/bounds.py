"""Where a search may go and where it starts: the joint limits, narrowed for one call, and shares of the way across them."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.kinematics.sample import usual_range
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def limit_bounds(limits: tuple[tuple[float, ...], tuple[float, ...]]) -> Array:
    """Lower and upper limits, and the usual range, from which starts are taken: shape (1, 4, n_dof)."""
    return np.array([[*limits, *usual_range(*limits)]])


def bounds_of(tree: Tree, seeds: Array, held: tuple[int, ...], max_step: float) -> Array:
    """The bounds of a search, shape (1 or n_seeds, 4, n_dof): the limits, less what is held or too far from the seed.

    Raises:
        InputError: A seed is so far beyond the limits that nothing is left.
    """
    bounds = limit_bounds(tree.bounds)
    if not held and np.isinf(max_step):
        return bounds
    reach = np.full(tree.n_dof, max_step)
    reach[list(held)] = 0.0
    lower, upper = np.maximum(bounds[:, 0], seeds - reach), np.minimum(bounds[:, 1], seeds + reach)
    beyond = np.argwhere(lower > upper)
    if len(beyond):
        what = "a joint that is held" if reach[beyond[0][1]] == 0.0 else "a joint"
        raise InputError("q_seed", f"{what} stands further beyond its limits than it may move (entry {beyond[0][1]} of q)")
    low, high = np.clip(bounds[:, 2], lower, upper), np.clip(bounds[:, 3], lower, upper)
    return np.stack([lower, upper, low, high], axis=1)
