"""Plans the problems of a batch whose straight edge is free, without a search."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.dynamics.dynamics import Dynamics
from ulna.planning.goals import is_free
from ulna.planning.motion import Motion
from ulna.planning.plan import Plan, PlanStatus, Searched
from ulna.planning.planner import PlanOptions
from ulna.planning.search import Effort
from ulna.planning.space import endless_entries, has_endless_slide, make_space, same_entries

Array = NDArray[np.float64]
_EFFORT = Effort(checks=2, start_nodes=1, goal_nodes=1)  # a search checks the straight edge, and confirms it


def plan_straight(
    checker: Checker,
    dynamics: Dynamics,
    ends: tuple[Array, Array],
    world: World | None,
    options: PlanOptions,
    certify: Callable[[Array, Array, World | None], NDArray[np.bool_]],
) -> list[Plan | None]:
    """Plan the problems whose straight edge is free as ``plan_motion`` does; None for all other problems.

    Problems that ``plan_motion`` does not solve by exactly this edge are left to it. In these, an end is not free or beyond the
    limits, or a joint has the same position at both ends. A robot with joints without limits has only such problems.

    ends: the starts and the goals, shape (n, n_dof) each. certify: the mask of the edges, from rows of the first array to rows of
    the second, that are certified to be free.
    """
    (starts, goals), tree = ends, checker.tree
    plans: list[Plan | None] = [None] * len(starts)
    if endless_entries(tree).any() or has_endless_slide(tree):
        return plans
    within = [((tree.lower_finite <= q) & (q <= tree.upper_finite)).all(axis=1) for q in ends]
    rows = np.flatnonzero(within[0] & within[1])
    rows = rows[~same_entries(tree, starts[rows], goals[rows]).any(axis=1)]
    seen, fixed = None if world is None else world.snapshot(), np.zeros(tree.n_dof, dtype=bool)
    for q in ends:
        rows = rows[is_free(checker, q[rows], seen, options.clearance)] if len(rows) else rows
    rows = rows[certify(starts[rows], goals[rows], seen)] if len(rows) else rows
    for i in rows.tolist():
        path = np.stack([starts[i], goals[i]])
        motion = Motion(make_space(tree, path, fixed), checker, seen, options.clearance, dynamics=dynamics)
        searched = Searched(motion, starts[i], goals[i : i + 1], np.zeros(1, dtype=np.int64), options.certify, options.seed)
        plans[i] = Plan(PlanStatus.SOLVED, path, options.certify, effort=_EFFORT, goal=0, _searched=searched)
    return plans
