"""Completes a closed form's results by those of the search, for targets without one within the limits."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.branches import PROOFS, all_branches
from ulna.ik.closed_form.closed_form import ClosedForm
from ulna.ik.closed_form.result import Proof
from ulna.ik.entry_names import entry_names
from ulna.ik.explain import reach_in_words
from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.numeric import NumericSolver, nearest_poses
from ulna.ik.problem import Problem, refuse_no_pose
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.turns import nearest_turns, turning_columns
from ulna.kernels.ik import search_layout as layout

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]
Truths = NDArray[np.bool_]


def with_unsolved(
    search: NumericSolver, form: ClosedForm, problem: Problem, q: Array, info: Array, found: Truths | None, world: World | None
) -> IKResult:
    """The result for q (n, n_dof) and info (n, N_INFO), of which some are not solved.

    found: Whether a target has a branch that is acceptable; None where the information says it.

    Raises:
        InputError: A target is no rigid motion.
    """
    options = problem.query.options
    if (info[:, layout.STATUS] == layout.NOT_A_POSE).any():
        refuse_no_pose(problem.targets.reshape(*problem.batch, 4, 4))
    solved = info[:, layout.STATUS] == layout.SOLVED
    rest = np.flatnonzero(~solved if found is None else ~(solved & found))
    explanation = Explanation(trace=no_steps(info) if options.trace else None)
    if len(rest):
        proved, excess = proved_unsolved(form, _some(problem, rest))
        if not options.trace:
            explanation = _nearest(form, problem, rest[proved], q, info, {int(rest[i]): x for i, x in excess.items()})
        else:
            proved[:] = False  # a trace is one of the search
        explanation = _searched(search, problem, rest[~proved], q, info, world, explanation)
    explanation = replace(explanation, task_axes=problem.query.task_axes)
    return IKResult(q.reshape(*problem.batch, q.shape[-1]), info, problem.batch, options.tolerances, explanation)


def proved_unsolved(form: ClosedForm, problem: Problem) -> tuple[Truths, dict[int, Array]]:
    """Which targets are proved to have no solution within the limits; and for those that have some beyond, the least excess."""
    branches = all_branches(form, problem.query.tree, problem.targets, problem.seeds, problem.query.options.threads)
    is_proof = np.isin(branches.proof, [PROOFS.index(proof) for proof in (Proof.COMPLETE, Proof.COINCIDING)])
    proved = is_proof & ~branches.valid.any(axis=1)
    beyond = np.flatnonzero(proved & branches.real.any(axis=1))
    return proved, {int(i): _least_excess(form, problem, branches.q[i, branches.real[i]]) for i in beyond}


def _some(problem: Problem, order: NDArray[np.int64]) -> Problem:
    """The problem of some targets."""
    seeds, bounds = (rows[order] if len(rows) > 1 else rows for rows in (problem.seeds, problem.bounds))
    goal = problem.nearest_to if problem.nearest_to is None or len(problem.nearest_to) == 1 else problem.nearest_to[order]
    return replace(problem, targets=problem.targets[order], seeds=seeds, bounds=bounds, nearest_to=goal, batch=(len(order),))


def _nearest(
    form: ClosedForm, problem: Problem, order: NDArray[np.int64], q: Array, info: Array, excess: dict[int, Array]
) -> Explanation:
    """Write the nearest configurations to targets without solutions, and why they have none."""
    if not len(order):
        return NOTHING_TO_EXPLAIN
    search = nearest_poses(_some(problem, order))
    q[order], info[order] = search.q, search.info
    open_ = order[search.info[:, layout.STATUS] != layout.SOLVED]  # within the tolerances although there is no solution
    is_beyond = np.isin(open_, list(excess))
    info[open_, layout.STATUS] = np.where(is_beyond, CODES[Status.JOINT_LIMITS], CODES[Status.UNREACHABLE])
    reach = {int(order[i]): x for i, x in search.reach_excess.items()}
    words = f"the closed form has no solution, whatever the limits ({form.family})"
    return Explanation(
        reach_excess=reach,
        limit_excess={i: x for i, x in excess.items() if i in set(open_.tolist())},
        reach=reach_in_words(problem, 0) if reach and not problem.batch else words,
        entry_names=entry_names(problem.query.tree) if excess else (),
    )


def _searched(
    search: NumericSolver,
    problem: Problem,
    order: NDArray[np.int64],
    q: Array,
    info: Array,
    world: World | None,
    known: Explanation,
) -> Explanation:
    """Write the results of the search for other targets; what is known of them too is added."""
    if not len(order):
        return known
    seeds = None if not problem.seeded else problem.seeds[order] if len(problem.seeds) > 1 else problem.seeds[0]
    targets = problem.targets[order] if problem.batch else problem.targets[0]
    some = search.solve(targets, seeds, None, (), world)
    q[order], info[order] = some.q.reshape(len(order), -1), some.info
    more = some.explanation
    return Explanation(
        reach_excess={**known.reach_excess, **{int(order[i]): x for i, x in more.reach_excess.items()}},
        limit_excess={**known.limit_excess, **{int(order[i]): x for i, x in more.limit_excess.items()}},
        collisions={int(order[i]): pairs for i, pairs in more.collisions.items()},
        reach=more.reach or known.reach,
        entry_names=more.entry_names or known.entry_names,
        trace=more.trace,
    )


def no_steps(info: Array) -> Array:
    """The trace (1, 4) of one target that took no step: its errors."""
    return np.array([[info[0, layout.POSITION_ERROR], info[0, layout.ROTATION_ERROR], 0.0, 0.0]])


def _least_excess(form: ClosedForm, problem: Problem, q: Array) -> Array:
    """How far beyond the limits that solution of some (k, n_dof) is, each turned towards them, that is the least so."""
    tree = problem.query.tree
    turning = turning_columns(form.chain, tree.n_dof)
    with np.errstate(invalid="ignore"):  # of joints without limits
        middle = np.where(np.isfinite(tree.lower) & np.isfinite(tree.upper), (tree.lower + tree.upper) / 2, q)
    q = nearest_turns(q, middle, np.full_like(tree.lower, -np.inf), np.full_like(tree.upper, np.inf), turning)
    excess = np.maximum(np.maximum(tree.lower - q, q - tree.upper), 0.0)
    return excess[excess.max(axis=1).argmin()]
