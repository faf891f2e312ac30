"""Completes a closed form's results by those of the search, for targets without one within the limits. Used by ``solver``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ulna.ik.closed_form.branches import PROOFS, all_branches
from ulna.ik.closed_form.closed_form import ClosedForm
from ulna.ik.closed_form.result import Proof
from ulna.ik.entry_names import entry_names
from ulna.ik.explanation import Explanation
from ulna.ik.numeric import NumericSolver
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
    if not len(rest):
        explanation = Explanation(trace=no_steps(info) if options.trace else None)
        return IKResult(q.reshape(*problem.batch, q.shape[-1]), info, problem.batch, options.tolerances, explanation)
    some = _searched(search, problem, rest, world)
    q[rest], info[rest] = some.q.reshape(len(rest), -1), some.info
    known = some.explanation
    reach = {int(rest[i]): x for i, x in known.reach_excess.items()}
    limits = {int(rest[i]): x for i, x in known.limit_excess.items()}
    collisions = {int(rest[i]): pairs for i, pairs in known.collisions.items()}
    proved, words = _proved(form, problem, rest, info, limits)
    info[rest, layout.STATUS] = proved
    explanation = Explanation(
        reach_excess=reach,
        limit_excess=limits,
        collisions=collisions,
        reach=known.reach or words,
        entry_names=entry_names(problem.query.tree) if limits else (),
        trace=known.trace,
    )
    return IKResult(q.reshape(*problem.batch, q.shape[-1]), info, problem.batch, options.tolerances, explanation)


def no_steps(info: Array) -> Array:
    """The trace (1, 4) of one target that took no step: its errors."""
    return np.array([[info[0, layout.POSITION_ERROR], info[0, layout.ROTATION_ERROR], 0.0, 0.0]])


def _searched(search: NumericSolver, problem: Problem, rest: NDArray[np.int64], world: World | None) -> IKResult:
    """The results of the search for some targets; of one target as it is given alone."""
    seeds = None if not problem.seeded else problem.seeds[rest] if len(problem.seeds) > 1 else problem.seeds[0]
    if not problem.batch:
        return search.solve(problem.targets[0], None if not problem.seeded else problem.seeds[0], None, (), world)
    return search.solve(problem.targets[rest], seeds, None, (), world)


def _proved(
    form: ClosedForm, problem: Problem, rest: NDArray[np.int64], info: Array, limits: dict[int, Array]
) -> tuple[Array, str]:
    """The statuses of some targets, those that the search left open by what the closed form proves; and that in words.

    The excess of targets that are proved to be beyond the limits is added to ``limits``.
    """
    status, words = info[rest, layout.STATUS].copy(), ""
    open_ = np.isin(status, [CODES[Status.NOT_FOUND], CODES[Status.SINGULAR]])
    if not open_.any():
        return status, words
    tree, order = problem.query.tree, rest[open_]
    seeds = problem.seeds if len(problem.seeds) == 1 else problem.seeds[order]
    branches = all_branches(form, tree, problem.targets[order], seeds, problem.query.options.threads)
    is_proof = np.isin(branches.proof, [PROOFS.index(proof) for proof in (Proof.COMPLETE, Proof.COINCIDING)])
    for row, i in enumerate(order):
        if not is_proof[row] or branches.valid[row].any():
            continue
        at = np.flatnonzero(rest == i)[0]
        if not branches.real[row].any():
            status[at] = CODES[Status.UNREACHABLE]
            words = f"the closed form has no solution, whatever the limits ({form.family})"
        elif status[at] == CODES[Status.NOT_FOUND]:
            status[at] = CODES[Status.JOINT_LIMITS]
            limits[int(i)] = _least_excess(form, problem, branches.q[row, branches.real[row]])
    return status, words


def _least_excess(form: ClosedForm, problem: Problem, q: Array) -> Array:
    """How far beyond the limits that solution of some (k, n_dof) is, each turned towards them, that is the least so."""
    tree = problem.query.tree
    turning = turning_columns(form.chain, tree.n_dof)
    middle = np.where(np.isfinite(tree.lower) & np.isfinite(tree.upper), (tree.lower + tree.upper) / 2, q)
    q = nearest_turns(q, middle, np.full_like(tree.lower, -np.inf), np.full_like(tree.upper, np.inf), turning)
    excess = np.maximum(np.maximum(tree.lower - q, q - tree.upper), 0.0)
    return excess[excess.max(axis=1).argmin()]
