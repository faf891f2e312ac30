"""Searches from the seed and from random starts until every target is solved or the budget is spent.

Every target gets one start; the remaining targets get more and more. The result for a target depends only on the target, its
seed, its bounds and the random seed. It does not depend on the rest of the batch, or on the division among threads.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import replaced
from ulna.engine.threads import in_parts
from ulna.ik.entries import multi_start
from ulna.ik.problem import SEEDED_STEPS, STEPS, Problem, rows_for
from ulna.ik.search.ranking import Cost
from ulna.ik.search.starts import closed_form_starts, unit_samples
from ulna.ik.search.units import solved_in_unit
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_records import Results, SearchResult
from ulna.kinematics.turns import nearest_turns, turning_columns

Array = NDArray[np.float64]
_JOBS_PER_THREAD = 1024
_JOBS_AT_ONCE = 1 << 16
_MAX_STARTS = 128  # of a target in one round


@dataclass(frozen=True)
class Restart:
    """``count`` starts for every target: random ones from number ``first`` on, after the seed itself if ``from_seed``."""

    first: int
    count: int
    steps: int
    from_seed: bool = False
    with_posture: bool = False
    calm: bool = False


def restarts_of(problem: Problem, n_first: int, *, seed_alone: bool) -> Iterator[Restart]:
    """The rounds of starts within the budget: the seed, then ``n_first`` random starts a target, twice as many ...

    Unless ``seed_alone``, the seed is one of ``n_first`` starts in the first round.
    """
    budget = problem.query.options.budget
    left, first = budget, 0
    if problem.settings[0].with_posture:
        yield Restart(0, 1, min(SEEDED_STEPS, left), from_seed=True, with_posture=True)
        left -= SEEDED_STEPS
    steps = SEEDED_STEPS if problem.seeded else STEPS
    if left > 0 or left == budget:
        count = 1 if seed_alone else max(1, min(n_first, left // steps))
        yield Restart(0, count, min(steps, left), from_seed=True)
        left, first = left - count * steps, count - 1
    while left > 0:
        count = min(n_first, max(1, left // STEPS))
        yield Restart(first, count, min(STEPS, left))
        left, first, n_first = left - count * STEPS, first + count, min(2 * n_first, _MAX_STARTS)


@dataclass(frozen=True, eq=False)
class PoseSearch:
    """The best results of a search, and the facts about unsolved targets; a target's index is its row.

    Attributes:
        problem: The targets.
        cost: The cost that ranks solutions; None if any solution is as good as the first.
        q: Shape (n, n_dof).
        info: Shape (n,).
        open: Whether the search for a target continues, shape (n,).
        rejected: For each target one colliding solution, with its information.
        origins: The configurations that other results were searched from.
        reach_excess: The distance of targets from the reach [m].
        limit_excess: The excess of joints over their bounds [rad or m].
        with_posture: Whether a result comes from a start with a posture, shape (n,).
    """

    problem: Problem
    cost: Cost | None
    q: Array
    info: Results
    open: NDArray[np.bool_]
    with_posture: NDArray[np.bool_]
    rejected: dict[int, tuple[Array, Any]] = field(default_factory=dict)
    origins: dict[int, Array] = field(default_factory=dict)
    reach_excess: dict[int, float] = field(default_factory=dict)
    limit_excess: dict[int, Array] = field(default_factory=dict)

    @classmethod
    def start(cls, problem: Problem, cost: Cost | None) -> "PoseSearch":
        """A search before its first round."""
        n, n_dof = len(problem.targets), problem.query.tree.n_dof
        info = np.zeros(n, SearchResult.structure)
        info["status"], info["residual_square"] = layout.NOT_FOUND, np.inf
        return cls(problem, cost, np.zeros((n, n_dof)), info, np.ones(n, dtype=bool), np.zeros(n, dtype=bool))

    def run(self, part: Restart) -> None:
        """Give every open target the starts of a round, and keep better results."""
        order = np.flatnonzero(self.open)
        size = max(1, _JOBS_AT_ONCE // part.count)  # the results of all would fill the memory otherwise
        for begin in range(0, len(order), size):
            piece = order[begin : begin + size]
            self.keep(piece, *run_starts(self.problem, piece, part), part)

    def run_from(self, order: NDArray[np.int64], origins: Array, steps: int) -> None:
        """Continue the search for some targets (m,) from their own configurations (m, k, n_dof), and keep solutions.

        The configurations are clipped to the bounds first. A result's start number is that of its configuration. For a solved
        target a result is kept if its cost is lower.
        """
        m, k, n_dof = origins.shape
        each = self.problem.subset(np.repeat(order, k))
        seeds = np.clip(origins.reshape(-1, n_dof), each.bounds[:, 0], each.bounds[:, 1])
        part = Restart(0, 1, steps, from_seed=True)
        q, info = run_starts(replace(each, seeds=seeds), np.arange(m * k), part)
        q, info = q.reshape(m, k, n_dof), info.reshape(m, k)
        info["start"] = np.arange(k)
        info["residual_square"][info["status"] != layout.SOLVED] = np.inf
        for row in np.flatnonzero(self.keep(order, q, info, part)):
            self.origins[int(order[row])] = seeds[row * k + int(self.info["start"][order[row]])]

    def keep(self, order: NDArray[np.int64], q: Array, info: Results, part: Restart) -> NDArray[np.bool_]:
        """Keep better results for some targets, and close solved targets. Whether a target has a new solution."""
        solved = info["status"] == layout.SOLVED
        costs, acceptable = np.full(solved.shape, np.inf), solved.copy()
        costs[solved], acceptable[solved] = self._costs(order[solved.nonzero()[0]], q[solved])
        self._note_rejected(order, q, info, solved & ~acceptable)
        chosen = np.where(acceptable.any(axis=1), costs.argmin(axis=1), info["residual_square"].argmin(axis=1))
        row = np.arange(len(order))
        q, info, accepted = q[row, chosen], info[row, chosen], costs[row, chosen] < self._costs_now(order)
        info["status"][~accepted & (info["status"] == layout.SOLVED)] = layout.NOT_FOUND
        info["start"] += part.first + (not part.from_seed)
        was_solved = self.info["status"][order] == layout.SOLVED
        is_better = accepted | (~was_solved & ~(info["residual_square"] >= self.info["residual_square"][order]))
        self.q[order[is_better]], self.info[order[is_better]] = q[is_better], info[is_better]
        self.with_posture[order[is_better]] = part.with_posture
        self.open[order[accepted | (info["status"] == layout.NOT_A_POSE)]] = False
        return accepted

    def copy_results(self, order: NDArray[np.int64], other: "PoseSearch") -> None:
        """Write the results of another search, for some of the targets (m,)."""
        self.q[order], self.info[order], self.with_posture[order] = other.q, other.info, other.with_posture
        for name in ("origins", "reach_excess", "limit_excess"):
            getattr(self, name).update({int(order[i]): value for i, value in getattr(other, name).items()})

    def _costs_now(self, order: NDArray[np.int64]) -> Array:
        """The costs of the present solutions of some targets, infinite without a solution."""
        costs, solved = np.full(len(order), np.inf), self.info["status"][order] == layout.SOLVED
        if solved.any():
            costs[solved], _ = self._costs(order[solved], self.q[order[solved]])
        return costs

    def _costs(self, order: NDArray[np.int64], q: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The costs (k,) of solutions q (k, n_dof) of some targets, infinite if unacceptable; and the mask of acceptable ones."""
        if self.cost is None:
            return np.zeros(len(q)), np.ones(len(q), dtype=bool)
        costs = self.cost(order, q)
        return costs.of_acceptable(), costs.acceptable

    def _note_rejected(self, order: NDArray[np.int64], q: Array, info: Results, refused: NDArray[np.bool_]) -> None:
        for row in np.flatnonzero(refused.any(axis=1)):
            k = refused[row].argmax()
            self.rejected.setdefault(int(order[row]), (q[row, k].copy(), info[row, k].copy()))


def run_from_branches(search: PoseSearch) -> None:
    """Start from branches of a closed form: for open targets, or for all if the best solution is wanted."""
    ranked = search.problem.query.options.rank is not None
    wanted = search.info["status"] != layout.NOT_A_POSE if ranked else search.open
    if not wanted.any():
        return
    order, starts = closed_form_starts(search.problem, np.flatnonzero(wanted), search.cost if ranked else None)
    if len(order):
        search.run_from(order, starts, steps=0)


def search_with_restarts(search: PoseSearch, n_first: int, give_up: Callable[[PoseSearch], None], *, seed_alone: bool) -> bool:
    """Run all rounds until no target is open, the budget is spent or time is up; True for the last.

    The first random round has ``n_first`` starts for every target. After it, ``give_up`` closes targets that are out of reach. A
    closed form closes the targets for which it has solutions, while budget is left. With a seed or a rank, this comes after the
    first round, to find the best. Otherwise it comes after two random rounds, which take less time.
    """
    options = search.problem.query.options
    of_branches = 0 if search.problem.seeded or options.rank is not None else 2
    end, used = np.inf if options.time_limit is None else time.monotonic() + options.time_limit, 0
    for number, part in enumerate(restarts_of(search.problem, n_first, seed_alone=seed_alone)):
        if number and time.monotonic() >= end:
            return bool(search.open.any())
        search.run(part)
        used += part.count * part.steps
        if number == 1 and search.open.any():
            give_up(search)
        if number == of_branches and used < options.budget:
            run_from_branches(search)
        if not search.open.any():
            break
    return False


def run_starts(problem: Problem, order: NDArray[np.int64], part: Restart) -> tuple[Array, Results]:
    """The results of every start of a round for some targets: q (m, n_starts, n_dof), info (m, n_starts)."""
    q, info = solved_in_unit(problem, order, lambda problem, order: _run_starts(problem, order, part))
    return _as_near_as_turns(problem, order, q), info


def run_from_each(
    problem: Problem, order: NDArray[np.int64], q: Array, steps: int, *, with_posture: bool = False
) -> tuple[Array, Results]:
    """The results for some targets (m,), each from its own configuration q (m, n_dof): q (m, n_dof), info (m,).

    Without steps the information is that of q itself.
    """
    each = replace(problem.subset(order), seeds=np.ascontiguousarray(q), nearest_to=None)
    part = Restart(0, 1, steps, from_seed=True, with_posture=with_posture)
    q, info = run_starts(each, np.arange(len(order)), part)
    return q[:, 0], info[:, 0]


def _run_starts(problem: Problem, order: NDArray[np.int64], part: Restart) -> tuple[Array, Results]:
    query, options = problem.query, problem.query.options
    n_dof = query.tree.n_dof
    starts = unit_samples(query.tree, query.link, options.seed, part.first, part.count, from_seed=part.from_seed)
    settings = replaced(problem.settings, steps=part.steps, with_posture=part.with_posture, calm=part.calm)
    q, info = np.empty((len(order), len(starts), n_dof)), np.zeros((len(order), len(starts)), SearchResult.structure)

    def piece(rows: slice) -> bool:
        jobs = multi_start.Jobs(problem.targets, order[rows], problem.seeds, problem.bounds, starts, problem.posture)
        own_q, own_info = q[rows].reshape(-1, n_dof), info[rows].reshape(-1)
        multi_start.search_jobs(problem.chain, settings, jobs, own_q, own_info)
        return True

    in_parts(piece, len(order), max(1, _JOBS_PER_THREAD // len(starts)))
    return q, info


def _as_near_as_turns(problem: Problem, order: NDArray[np.int64], q: Array) -> Array:
    """Move q (m, n_starts, n_dof) by whole turns nearest to ``nearest_to``, if that is given."""
    if problem.nearest_to is None:
        return q
    goal, bounds = (rows_for(rows, order)[:, None] for rows in (problem.nearest_to, problem.bounds))
    return nearest_turns(q, goal, bounds[:, :, 0], bounds[:, :, 1], turning_columns(problem.chain, q.shape[-1]))
