"""Takes of all branches within the limits the best by a rank, clear of a world."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.pose import as_pose
from ulna.ik.closed_form.branches import Branches, all_branches
from ulna.ik.closed_form.closed_form import ClosedForm
from ulna.ik.closed_form.unsolved import with_unsolved
from ulna.ik.collision_filter import CollisionFilter
from ulna.ik.numeric import NumericSolver
from ulna.ik.problem import Problem, make_problem, mid_range
from ulna.ik.query import Query
from ulna.ik.ranking import Cost, cost_of, refuse_clearance_of_nothing
from ulna.ik.restarts import Restart, run_starts
from ulna.ik.result import IKResult

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]


def best_branches(
    query: Query, form: ClosedForm, search: NumericSolver, T: ArrayLike, q_seed: ArrayLike | None, world: World | None
) -> IKResult:
    """The best branch of each target."""
    refuse_clearance_of_nothing(query.options.rank, world)
    problem = make_problem(query, T, q_seed)
    as_pose(problem.targets.reshape(*problem.batch, 4, 4))
    collisions = None if world is None else CollisionFilter(query.checker, world, query.options.threads)
    cost = cost_of(problem, collisions)
    if cost is None:
        raise AssertionError("a rank or a world gives a cost")
    goal = mid_range(query.tree)[None] if query.options.rank == "mid_range" else problem.seeds
    branches = all_branches(form, query.tree, problem.targets, goal, query.options.threads)
    q, found = _best(branches, cost, problem)
    each = replace(problem, seeds=q, nearest_to=None)
    q, info = run_starts(each, np.arange(len(q)), Restart(0, 1, 0, from_seed=True))  # no step: the errors at q
    return with_unsolved(search, form, problem, q[:, 0], info[:, 0], found, world)


def _best(branches: Branches, cost: Cost, problem: Problem) -> tuple[Array, NDArray[np.bool_]]:
    """The branch of the least cost of each target, shape (n, n_dof), and whether there is one that is acceptable."""
    order, which = np.nonzero(branches.valid)
    costs = np.full(branches.valid.shape, np.inf)
    costs[order, which] = cost(order, branches.q[order, which])
    chosen, rows = costs.argmin(axis=1), np.arange(len(costs))
    found = np.isfinite(costs[rows, chosen])
    seeds = np.broadcast_to(problem.seeds, (len(costs), problem.seeds.shape[1]))
    return np.where(found[:, None], branches.q[rows, chosen], seeds), found
