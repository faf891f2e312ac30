"""Chooses the starts of searches: the seed, random ones, joints at limits, and branches of the closed form.

Branches serve arms of seven joints. Random starts are numbers between 0 and 1, one row for each start, reproducible for a robot
and a seed. NaN stands for the seed's own entry.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.branches import branches_at
from ulna.ik.closed_form.closed_form import closed_form_of, held_range
from ulna.ik.problem import Problem, rows_for
from ulna.ik.search.ranking import Cost
from ulna.kernels.ik.search_layout import WHOLE_POSE
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_TABLE = 1024  # rows of a cached block
_OWN_STREAM = 0x756C6E61  # a caller who draws targets with the same seed must not draw the same numbers
_PLACES, _STARTS = 8, 8


def unit_samples(tree: Tree, link: str, seed: int, first: int, count: int, *, from_seed: bool = False) -> Array:
    """Starts (count, n_dof), in [0, 1): the random ones from number ``first`` on, after the seed itself if ``from_seed``.

    Entries of q that do not move the link are NaN, and stay at the seed.
    """
    samples, n_random = np.full((count, tree.n_dof), np.nan), count - from_seed
    if n_random > 0:
        blocks = range(first // _TABLE, (first + n_random - 1) // _TABLE + 1)
        rows = np.concatenate([_block(tree.n_dof, seed, block) for block in blocks])
        start, moving = first - blocks[0] * _TABLE, tree.moving_columns(link)
        samples[int(from_seed) :, moving] = rows[start : start + n_random, moving]
    return samples


@lru_cache(maxsize=64)
def _block(n_dof: int, seed: int, block: int) -> Array:
    return np.random.default_rng([_OWN_STREAM, seed, block]).random((_TABLE, n_dof))


def closed_form_starts(
    problem: Problem, order: NDArray[np.int64], cost_of: Cost | None = None
) -> tuple[NDArray[np.int64], Array]:
    """Starts from closed-form branches of seven joints, shape (m, 8, n_dof), after the targets' indices (m,).

    The held joint takes eight positions: that of the seed, and seven more spread over its range. The starts are the branches
    within the limits nearest to the seed, or with ``cost_of`` those of minimum cost. If there are fewer than eight, the first is
    repeated. Branches of an exact form are already solutions.
    """
    query, tree = problem.query, problem.query.tree
    task, empty = query.options.task, (order[:0], np.empty((0, _STARTS, tree.n_dof)))
    form = closed_form_of(tree, query.link, task=task) if task.kind == WHOLE_POSE and len(order) else None
    if form is None or form.held_column is None:
        return empty
    seeds = rows_for(problem.seeds, order)
    bounds = rows_for(problem.bounds, order)
    low, high = held_range(tree, form.held_column)
    spread = low + (np.arange(_PLACES - 1) + 0.5) / (_PLACES - 1) * (high - low)
    places = np.column_stack([seeds[:, form.held_column], np.broadcast_to(spread, (len(order), _PLACES - 1))])
    found = branches_at(form, tree, problem.targets[order], seeds, places)
    q, valid = found.q, found.valid
    valid = valid & ((q >= bounds[:, None, 0]) & (q <= bounds[:, None, 1])).all(axis=-1)
    cost = np.where(valid, np.abs(q - seeds[:, None]).max(axis=-1), np.inf)
    if cost_of is not None:
        indices = np.nonzero(valid)
        cost[indices] = cost_of(order[indices[0]], q[indices]).of_acceptable()
    nearest = np.argsort(cost, axis=1, kind="stable")[:, :_STARTS]
    rows = np.arange(len(order))[:, None]
    nearest = np.where(np.isfinite(cost[rows, nearest]), nearest, nearest[:, :1])
    has_any = np.isfinite(cost).any(axis=1)
    return order[has_any], q[rows, nearest][has_any]


def limit_starts(problem: Problem, order: NDArray[np.int64], count: int) -> Array:
    """Random configurations to search some targets from, shape (m, count, n_dof), about two thirds of the joints at a bound.

    They serve targets at the border of the limits, where few starts from within lead.
    """
    query = problem.query
    seeds, bounds = (rows_for(rows, order)[:, None] for rows in (problem.seeds, problem.bounds))
    samples = unit_samples(query.tree, query.link, query.options.seed, 0, count)
    share = np.clip(3.0 * samples - 1.0, 0.0, 1.0)
    return np.where(np.isnan(samples), seeds, bounds[:, :, 2] + share * (bounds[:, :, 3] - bounds[:, :, 2]))
