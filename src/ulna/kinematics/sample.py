"""Draws random joint positions within the limits. Used by ``ik``, ``dh``, ``comparison``, ``bench`` and ``sampled_pairs``."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.kinematics.tree import Tree

_NO_LIMIT = 1e3  # descriptions write 1e16 for no limit; positions drawn from such a range would be useless


def usual_range(lower: ArrayLike, upper: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The limits; if one is infinite or very large, a turn from the other one, or pi to both sides of zero."""
    sides = (np.asarray(side, dtype=np.float64) for side in (lower, upper))
    lower, upper = (np.where(np.abs(side) > _NO_LIMIT, np.copysign(np.inf, side), side) for side in sides)
    low = np.where(np.isinf(lower), np.where(np.isinf(upper), -np.pi, np.subtract(upper, 2 * np.pi)), lower)
    return low, np.where(np.isinf(upper), low + 2 * np.pi, upper)


def random_positions(tree: Tree, n: int, seed: int = 0) -> NDArray[np.float64]:
    """Joint positions within the usual range [rad or m], shape (n, n_dof): the same for the same robot and seed."""
    return np.random.default_rng(seed).uniform(*usual_range(tree.lower, tree.upper), (n, tree.n_dof))
