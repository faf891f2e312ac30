"""Solves by Levenberg-Marquardt from many starts, and explains unreached targets: the interface of this folder.

The idea. Let e(q) be the pose error, six numbers (m, rad) in the axes of the base, and J the Jacobian. A step

    dq = J' (J J' + lambda I)^-1 e,    lambda = 0.05 |e|^2 + 1e-12    (Sugihara 2011)

is long and damped far from the target, and becomes Newton's near it, where lambda vanishes. Every step is kept within the limits
(``kernels/ik``). It may end in a local minimum of |e|, so there are many starts (``starts``): the caller's seed, random ones, and
for seven joints branches of the closed form. Eight searches run at a time, one a lane; a finished search makes room for the next.

1. The fast path is one call of the kernels for one target with default options (``NumericSolver.solve``).
2. ``restarts``: rounds for a batch, of one start each, then of more and more for the remaining targets. ``ranking``: the choice
   among several solutions. ``units``: arms that are far from a meter long are searched in a unit of their own.
3. ``diagnosis``: for targets without a solution the nearest pose, and the reason: reach, limits, collision or a singularity.
4. ``branch_search``: all solutions of one target.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.engine.bound import bind
from ulna.engine.records import replaced
from ulna.ik.entries import multi_start
from ulna.ik.options import Request
from ulna.ik.problem import SEEDED_STEPS, STEPS, Problem, Query, make_problem, refuse_no_pose
from ulna.ik.reason import Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.diagnosis import close_unreachable, explain_open, reach_in_words, settle_open
from ulna.ik.search.ranking import CollisionFilter, collisions_of, cost_of, refuse_clearance_of_nothing
from ulna.ik.search.restarts import PoseSearch, Restart, run_from_each, search_with_restarts
from ulna.ik.search.starts import unit_samples
from ulna.kernels.ik import search_layout as layout
from ulna.kernels.ik.search_records import Results, SearchResult
from ulna.kinematics.tree import entry_names

Array = NDArray[np.float64]
_FEW, _MANY = 2, 16  # random starts of the first round: if any solution will do, and if the best is chosen
_MAX_STARTS = 64  # starts of one target with default options, eight in each lane; and for targets without a solution


_MATRIX = 4, 4
OfOneTarget = Callable[[ArrayLike, ArrayLike], tuple[Array, Results] | None]
"""From T and a start to q (n_dof,) and its information (1,); None if this is not one target, or it is not solved."""


def bound_to_one_target(run: Any, tables: tuple[Any, ...], home: Array) -> OfOneTarget:
    """The entry ``run(*tables, T, start, q, info)``, in C if the extension is there.

    ``home`` as a start is not validated.
    """
    n, of_q, of_info = len(home), (1, len(home)), SearchResult.structure

    def in_python(T: ArrayLike, start: ArrayLike) -> tuple[Array, Results] | None:
        target = as_floats("T", T)
        if target.shape != _MATRIX:
            return None
        if start is not home:
            start = as_floats("q_seed", start)
            if start.shape != (n,):
                return None
        q, info = np.empty(of_q), np.empty(1, of_info)
        return (q[0], info) if run(*tables, target, start, q, info) else None

    return bind(run, "search", tables, n, (), in_python, np.zeros(1, of_info))


class NumericSolver:
    """The Levenberg-Marquardt solver for any query; see ``ik.inverse_kinematics.Solver``.

    Attributes:
        tables: The kernels' arguments before one target with default options, from home; empty for other options.
        home: The start of a search without a seed, shape (n_dof,).
    """

    __slots__ = ("_from_home", "_from_seed", "_query", "_tolerances", "home", "tables")

    def __init__(self, query: Query) -> None:
        self._query, self.home, self.tables = query, query.home.copy(), ()
        self._tolerances = query.options.tolerances
        self._from_home = self._from_seed = None
        if _fits_one_call(query):
            settings, run = replaced(query.settings, first_wins=layout.ANY), multi_start.search_one
            starts = unit_samples(query.tree, query.link, query.options.seed, 0, _MAX_STARTS, from_seed=True)
            plan = np.concatenate([query.limits.ravel(), query.home, starts.ravel()])
            self.tables = query.chain, settings, plan
            from_seed = replaced(settings, first_wins=layout.NEAREST, seeded_steps=SEEDED_STEPS)
            self._from_home = bound_to_one_target(run, self.tables, self.home)
            self._from_seed = bound_to_one_target(run, (query.chain, from_seed, plan), self.home)

    def solve(self, request: Request) -> IKResult:
        """The first solution for one target with default options; otherwise the best result of a search."""
        if self._from_home is None or request.posture is not None or request.world is not None or request.held:
            return self.search(request)
        found = self._found(request.T, request.q_seed)
        if found is None:
            return self.search(request)
        q, info = found
        if self._query.options.trace:
            explanation = Explanation(trace=_convergence(make_problem(self._query, request.T, request.q_seed), info[0]))
            return IKResult(q, info, (), self._tolerances, explanation)
        return IKResult(q, info, (), self._tolerances)

    def with_defaults(self, T: ArrayLike, q_seed: ArrayLike | None) -> IKResult:
        """``solve`` of a query with default options, for targets alone."""
        found = self._found(T, q_seed)
        return self.search(Request(T, q_seed)) if found is None else IKResult(*found, (), self._tolerances)

    def _found(self, T: ArrayLike, q_seed: ArrayLike | None) -> tuple[Array, Results] | None:
        """The solution for one target with default options, by one call of the kernels; None if it finds none."""
        if self._from_home is None or self._from_seed is None:
            return None
        return self._from_home(T, self.home) if q_seed is None else self._from_seed(T, q_seed)

    def search(self, request: Request) -> IKResult:
        """The best results of the restarts for any targets."""
        problem = make_problem(self._query, request.T, request.q_seed, request.posture, request.held)
        refuse_clearance_of_nothing(self._query.options.rank, request.world)
        collisions = collisions_of(self._query, request.world)
        search = searched(problem, collisions)
        if (search.info["status"] == layout.NOT_A_POSE).any():
            refuse_no_pose(request.T)
        return result_of(search, collisions, trace_of(search))


def _fits_one_call(query: Query) -> bool:
    """Whether one call of the kernels covers the options for one target, and the arm is measured in meters."""
    options = query.options
    return (
        options.task.kind == layout.WHOLE_POSE
        and query.task_axes is None
        and options.rank is None
        and options.max_step is None
        and options.budget >= SEEDED_STEPS + (_MAX_STARTS - 1) * STEPS
        and options.time_limit != 0.0
        and query.unit == 1.0
    )


def nearest_poses(problem: Problem) -> PoseSearch:
    """The nearest configurations to targets without a solution within the limits; targets out of reach are marked."""
    search = PoseSearch.start(problem, None)
    search.run(Restart(0, _MAX_STARTS, STEPS, from_seed=True))
    close_unreachable(search)
    settle_open(search, out_of_time=False)
    return search


def searched(problem: Problem, collisions: CollisionFilter | None) -> PoseSearch:
    """Search with restarts; then, for unsolved targets, find the best reachable pose and the reason."""
    rank = problem.query.options.rank
    cost, count = cost_of(problem, collisions), _FEW if rank is None and collisions is None else _MANY
    search = PoseSearch.start(problem, cost)
    out_of_time = search_with_restarts(search, count, close_unreachable, seed_alone=rank is None)
    if not (search.info["status"] == layout.SOLVED).all():
        settle_open(search, out_of_time=out_of_time)
        explain_open(search, out_of_time=out_of_time)
    return search


def result_of(search: PoseSearch, collisions: CollisionFilter | None, trace: Array | None, no_solution: str = "") -> IKResult:
    """The result of a search, with explanations. no_solution: The reason why a target within reach has no solution."""
    problem, query = search.problem, search.problem.query
    hit = np.flatnonzero(search.info["status"] == CODES[Status.IN_COLLISION])
    explanation = Explanation(
        reach_excess=search.reach_excess,
        limit_excess=search.limit_excess,
        collisions={} if collisions is None else {int(i): collisions.pairs(search.q[i]) for i in hit},
        reach=reach_in_words(problem, 0) if search.reach_excess and not problem.batch else no_solution,
        entry_names=entry_names(query.tree) if search.limit_excess else (),
        task_axes=query.task_axes,
        trace=trace,
    )
    q = search.q.reshape(*problem.batch, search.q.shape[-1])
    return IKResult(q, search.info, problem.batch, query.options.tolerances, explanation)


def trace_of(search: PoseSearch) -> Array | None:
    """The trace of the result for one target; None unless the options ask for it."""
    if not search.problem.query.options.trace:
        return None
    return _convergence(search.problem, search.info[0], search.origins.get(0), with_posture=bool(search.with_posture[0]))


def _convergence(problem: Problem, info: Any, origin: Array | None = None, *, with_posture: bool = False) -> Array:
    """One row a step towards a result: errors [m] and [rad], largest joint step, damping; (steps + 1, 4).

    origin: The configuration that the search continued from, (n_dof,), if the result has no start of a round. A step depends on
    the configuration alone, so single steps give the same result.
    """
    start, steps = int(info.start), int(info.iterations)
    q = _start(problem, start) if origin is None else origin
    rows, first_target = [], np.zeros(1, dtype=np.int64)
    for k in range(steps + 1):
        _, (at_q,) = run_from_each(problem, first_target, q[None], 0, with_posture=with_posture)
        (q_after,), _ = run_from_each(problem, first_target, q[None], 1, with_posture=with_posture)
        step = np.abs(q_after - q).max() if k < steps else 0.0
        rows.append([at_q.position_error, at_q.rotation_error, step, at_q.damping])
        q = q_after
    table = np.array(rows)
    table[1:, 2], table[0, 2] = table[:-1, 2].copy(), 0.0
    return table


def _start(problem: Problem, start: int) -> Array:
    if start == 0:
        return problem.seeds[0]
    query = problem.query
    lower, upper, low, high = problem.bounds[0]
    share = unit_samples(query.tree, query.link, query.options.seed, start - 1, 1)[0]
    return np.clip(np.where(np.isnan(share), problem.seeds[0], low + share * (high - low)), lower, upper)
