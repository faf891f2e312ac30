"""Finds starts of a search for arms of seven joints: branches of their closed form.

The held joint is put to eight places: that of the seed, and seven more spread over its range. Of the branches within the limits
the nearest to the seed, or those of the best rank, are the starts; of an exact form each is a solution already.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.branches import at_places
from ulna.ik.closed_form.closed_form import closed_form_of, held_range
from ulna.ik.problem import Problem
from ulna.ik.ranking import Cost
from ulna.kernels.ik.search_layout import WHOLE_POSE

Array = NDArray[np.float64]
_PLACES, _STARTS = 8, 8


def closed_form_starts(
    problem: Problem, order: NDArray[np.int64], cost_of: Cost | None = None
) -> tuple[NDArray[np.int64], Array]:
    """Those of some targets that have starts, shape (m,), and their starts, shape (m, 8, n_dof); if fewer, the first again.

    With ``cost_of`` they are the branches of the least cost instead of the nearest.
    """
    query, tree = problem.query, problem.query.tree
    task, none = query.options.task, (order[:0], np.empty((0, _STARTS, tree.n_dof)))
    form = closed_form_of(tree, query.link, task=task) if task.kind == WHOLE_POSE and len(order) else None
    if form is None or form.held_column is None:
        return none
    seeds = problem.seeds[np.minimum(order, len(problem.seeds) - 1)]
    bounds = problem.bounds[np.minimum(order, len(problem.bounds) - 1)]
    low, high = held_range(tree, form.held_column)
    spread = low + (np.arange(_PLACES - 1) + 0.5) / (_PLACES - 1) * (high - low)
    places = np.column_stack([seeds[:, form.held_column], np.broadcast_to(spread, (len(order), _PLACES - 1))])
    found = at_places(form, tree, problem.targets[order], seeds, places, query.options.threads)
    q, valid = found.q, found.valid
    valid = valid & ((q >= bounds[:, None, 0]) & (q <= bounds[:, None, 1])).all(axis=-1)
    cost = np.where(valid, np.abs(q - seeds[:, None]).max(axis=-1), np.inf)
    if cost_of is not None:
        which = np.nonzero(valid)
        cost[which] = cost_of(order[which[0]], q[which])
    nearest = np.argsort(cost, axis=1, kind="stable")[:, :_STARTS]
    rows = np.arange(len(order))[:, None]
    nearest = np.where(np.isfinite(cost[rows, nearest]), nearest, nearest[:, :1])
    known = np.isfinite(cost).any(axis=1)
    return order[known], q[rows, nearest][known]
