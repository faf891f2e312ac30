"""Draws the starts of a search as numbers between 0 and 1."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_TABLE = 1024  # shares that are kept
_OWN_STREAM = 0x756C6E61  # a caller who draws targets with the same seed must not draw the same numbers


def seed_sample(n_dof: int) -> Array:
    """The one start that is the seed itself, shape (1, n_dof)."""
    return np.full((1, n_dof), np.nan)


def unit_samples(tree: Tree, link: str, seed: int, first: int, count: int) -> Array:
    """The random starts ``first`` to ``first + count``: shape (count, n_dof), in [0, 1).

    Entries of q that do not move the link are NaN, and stay at the seed.
    """
    blocks = range(first // _TABLE, (first + count - 1) // _TABLE + 1)
    rows = np.concatenate([_block(tree.n_dof, seed, block) for block in blocks])
    start, moving = first - blocks[0] * _TABLE, tree.moving_columns(link)
    chosen = np.full((count, tree.n_dof), np.nan)
    chosen[:, moving] = rows[start : start + count, moving]
    return chosen


def limit_samples(tree: Tree, link: str, seed: int, count: int) -> Array:
    """Random starts with about two thirds of the joints at a limit: shape (count, n_dof), in [0, 1]; NaN as above.

    For targets at the border of what the limits allow, where few of the starts from within lead.
    """
    samples = unit_samples(tree, link, seed, 0, count)
    with np.errstate(invalid="ignore"):
        return np.where(np.isnan(samples), samples, np.clip(3.0 * samples - 1.0, 0.0, 1.0))


@lru_cache(maxsize=64)
def _block(n_dof: int, seed: int, block: int) -> Array:
    return np.random.default_rng([_OWN_STREAM, seed, block]).random((_TABLE, n_dof))
