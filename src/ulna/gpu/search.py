"""Solves inverse kinematics for many targets on a GPU, from as many starts as the CPU; explains failures later.

1. Each thread searches for a target by Levenberg-Marquardt, from the seed and from a few random starts, until one is solved. With
   a world, a colliding solution does not count: its target is searched again, from its next starts.
2. Remaining targets are searched from more and more starts at once, one start per thread, until the budget is spent. The first
   start with a solution wins.
3. Targets whose solutions all collide are known then. Reasons for the other failures are computed by the CPU, at the first
   access.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.dynamics.dynamics import Dynamics
from ulna.engine.decorators import kernel
from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.gpu.device_array import as_shaped
from ulna.gpu.queue import Queue
from ulna.gpu.staged import MATRIX, over_rows
from ulna.ik.entries.lane_state import reset_state, write_bounds, write_result, write_start, write_target
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import Request
from ulna.ik.problem import STEPS, Query, refuse_no_pose
from ulna.ik.reason import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.result import CODES, IKResult, Status
from ulna.ik.search.ranking import CollisionFilter
from ulna.ik.search.starts import unit_samples
from ulna.kernels.ik.levenberg_marquardt import ENDED, HAS_SOLVED, N_STATE, P2, R2, RUNNING, advance
from ulna.kernels.ik.search_layout import N_SYSTEM, NOT_A_POSE, NOT_FOUND, SOLVED
from ulna.kernels.ik.search_records import Results, SearchResult
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect
from ulna.kinematics.tree import Tree
from ulna.planning.plan import Plan

Array = NDArray[np.float64]
_FEW = 16  # starts that one thread tries in sequence
_ROUNDS = 4  # repetitions of that for targets whose solutions collide
_AT_ONCE = 16, 64, 192, 448  # afterwards starts are tried in parallel, up to each of these numbers
_SEARCHES = 1 << 16  # threads that search
_JOBS = 1 << 20  # starts whose results are stored at a time
_COLLIDES = CODES[Status.IN_COLLISION]


class OnHost(Protocol):
    """The members of a robot on the CPU that this folder uses; ``robot``, a layer above, passes itself to ``GpuRobot``."""

    tree: Tree
    """Its tree in flat arrays."""
    home: Array
    """The default start [rad or m], shape (n_dof,)."""
    plan: Callable[..., Plan]
    """Plans a path."""
    plan_many: Callable[..., tuple[Plan, ...]]
    """Plans many problems."""
    _checker: Checker
    _dynamics: Dynamics
    _inverse_kinematics: InverseKinematics


class Tables(NamedTuple):
    """Tables that all searches of a query share, on the device; see ``ik.entries.multi_start``."""

    chain: Any
    seeds: Any
    box: Any
    samples: Any
    posture: Any
    settings: Any


def tables_of(query: Query) -> Tables:
    """The tables of a query, for searches from ``home``."""
    n_starts = max(1, query.options.budget // STEPS)
    starts = unit_samples(query.tree, query.link, query.options.seed, 0, n_starts, from_seed=True)
    parts = query.chain, query.home[None], query.limits[0], starts, query.home, query.settings
    return Tables(*(device.on_device(part) for part in parts))


class _Jobs(NamedTuple):
    """The targets and starts of a search.

    Attributes:
        order: Indices of the targets, shape (m,); empty: all of them.
        following: The first start of each target, shape (n,); empty: ``first`` for all.
        first: The index of the first start.
        end: The index after the last start.
        runs: The number of threads that share the starts of a target.
        n: The number of jobs: m times runs.
    """

    order: Any
    following: Any
    first: int
    end: int
    runs: int
    n: int


@dataclass(frozen=True, eq=False)
class DeviceSearch:
    """A search for several targets.

    Attributes:
        query: The link and the options.
        tables: Its tables on the device.
        queue: The queue of the launches.
        collides: Whether configurations (k, n_dof) on the device collide, bools of shape (k, 1) there; None without a world.
    """

    query: Query
    tables: Tables
    queue: Queue
    collides: Callable[[Any], Any] | None

    def of(self, targets: Any, flag: Any) -> tuple[Any, Any, int]:
        """q (n, n_dof) and info (n,) for targets (n, 4, 4) on the device, and the number of unsolved ones.

        It flags targets that are no pose.
        """
        n, n_starts, stream = len(targets), self.tables.samples.shape[0], self.queue.stream
        targets, none = self._of_task(targets), device.empty((0,), np.int64, stream)
        q, info = self._empty(n)
        following = device.empty((n,), np.int64, stream)
        few = min(_FEW, n_starts)
        runs = few if n * few <= _SEARCHES else 1
        left = self._search(_Jobs(none, none, 0, few, runs, n * runs), targets, (q, info, following), flag)
        for _ in range(_ROUNDS if runs == 1 and self.collides else 0):
            left = self._search(_Jobs(left, following, 0, few, 1, len(left)), targets, (q, info, following), flag)
        first = 0 if runs == 1 and self.collides else few
        for end in (*_AT_ONCE, n_starts):
            last = min(end, n_starts)
            if last <= first:
                continue
            size = max(1, _JOBS // (last - first))
            parts = [left[k : k + size] for k in range(0, len(left), size)]
            ways = [_Jobs(part, none, first, last, last - first, len(part) * (last - first)) for part in parts]
            rests = [self._search(jobs, targets, (q, info, following), flag) for jobs in ways]
            left, first = _joined([rest for rest in rests if len(rest)], none, stream), last
        return q, info, len(left)

    def _search(self, jobs: _Jobs, targets: Any, results: tuple[Any, Any, Any], flag: Any) -> Any:
        """Search for some targets, and store better results; returns the indices of unsolved targets, on the device."""
        n, stream = jobs.n // jobs.runs, self.queue.stream
        if not n:
            return device.empty((0,), np.int64, stream)
        in_place = not len(jobs.order) and jobs.runs == 1
        q, info = results[:2] if in_place else self._empty(jobs.n)
        counts = device.empty((2,), np.int64, stream)
        counts.copy_to_device(self.queue.zeros, stream=stream)  # on the device; a copy from the host would wait
        grid = device.blocks(min(jobs.n, _SEARCHES)), device.THREADS, stream
        device.compiled(searches_of(q.shape[1]))[grid](*self.tables, tuple(jobs), targets, q, info, (flag, counts))
        hits = device.empty((0, 1), np.bool_, stream) if self.collides is None else self.collides(q)
        left = device.empty((n,), np.int64, stream)
        grid = device.blocks(n), device.THREADS, stream
        device.compiled(choose)[grid](tuple(jobs), q, info, hits, *results, left, counts)
        return left[: int(device.on_host(counts, stream)[1])]

    def _empty(self, n: int) -> tuple[Any, Any]:
        stream = self.queue.stream
        return device.empty((n, self.query.tree.n_dof), np.float64, stream), device.empty((n,), SearchResult.structure, stream)

    def _of_task(self, targets: Any) -> Any:
        """Transform the link's targets to the task's frame."""
        if self.query.task_axes is None or not len(targets):
            return targets
        stream, spare = self.queue.stream, self.queue.spare
        out, table = device.empty((len(targets), MATRIX), np.float64, stream), device.on_device(self.query.T_link_task, stream)
        device.run(turned_of(), (table,), targets, (out,), spare, device.Launch(stream=stream))
        return as_shaped(out, (len(targets), 4, 4))


def _joined(parts: list[Any], none: Any, stream: Any) -> Any:
    """Concatenate arrays on the device."""
    if len(parts) < 2:
        return parts[0] if parts else none
    out = device.empty((sum(map(len, parts)),), np.int64, stream)
    first = 0
    for part in parts:
        out[first : first + len(part)].copy_to_device(part, stream=stream)
        first += len(part)
    return out


@dataclass(frozen=True, eq=False)
class Unsolved:
    """The request to the CPU about unsolved targets.

    Attributes:
        on_host: The CPU's inverse kinematics.
        request: Its arguments, which no caller changes later. Targets and seeds are all of them, the targets on the device; no
            targets if all are solved.
        query: The prepared request.
    """

    on_host: InverseKinematics
    request: Request
    query: Query

    def by_cpu(self, order: NDArray[np.int64], is_batch: bool) -> IKResult:
        """The result of the CPU for some targets."""
        targets, seeds = device.on_host(self.request.T)[order], self.request.q_seed
        if seeds is not None:
            seeds = np.asarray(seeds)
            seeds = seeds[order] if len(seeds) > 1 else seeds[0]
        return self.on_host.inverse_kinematics(self.request._replace(T=targets if is_batch else targets[0], q_seed=seeds))

    def explained(self, info: Results, is_batch: bool) -> tuple[Results, Explanation]:
        """The results with the statuses of the CPU, and their explanation, except for the pairs that collide."""
        rest = np.flatnonzero(~np.isin(info["status"], (SOLVED, _COLLIDES)))
        if not len(rest):
            return info, replace(NOTHING_TO_EXPLAIN, task_axes=self.query.task_axes)
        found, info = self.by_cpu(rest, is_batch), info.copy()
        status = found.info["status"]
        info["status"][rest] = np.where(status == SOLVED, NOT_FOUND, status)  # q holds no solution
        return info, found.explanation.renumbered(rest)

    def collisions(self, info: Results, q: Array) -> dict[int, tuple[tuple[str, str], ...]]:
        """The colliding pairs at the configurations (n, n_dof) of targets whose solutions all collide."""
        if self.request.world is None:
            return {}
        pairs = CollisionFilter(self.query.checker, self.request.world).pairs
        return {int(i): pairs(q[i]) for i in np.flatnonzero(info["status"] == _COLLIDES)}


class DeviceResult(IKResult):
    """An ``IKResult`` of the GPU, whose data are copied to the host at the first access.

    The CPU computes statuses and reasons of unsolved targets at the first access, unless all of their solutions collide.
    ``success`` and ``q`` never wait for that.
    """

    def __init__(
        self, q: Any, info: Any, batch: tuple[int, ...], tolerances: tuple[float, float], unsolved: Unsolved | Explanation
    ) -> None:
        known = {"q": q, "_there": info, "_batch": batch, "tolerances": tolerances, "_unsolved": unsolved}
        for name, value in known.items():
            object.__setattr__(self, name, value)

    @cached_property
    def info(self) -> Results:  # pyright: ignore[reportIncompatibleVariableOverride] - it is as read-only
        """The result for each target; its status is SOLVED, IN_COLLISION if all solutions collide, or NOT_FOUND."""
        return device.on_host(self.__dict__["_there"])

    @cached_property
    def _explained(self) -> tuple[Results, Explanation]:
        unsolved = self.__dict__["_unsolved"]
        return (self.info, unsolved) if isinstance(unsolved, Explanation) else unsolved.explained(self.info, bool(self._batch))

    @cached_property
    def explanation(self) -> Explanation:  # pyright: ignore[reportIncompatibleVariableOverride] - it is as read-only
        """The explanation of the unsolved targets."""
        (info, explanation), unsolved = self._explained, self.__dict__["_unsolved"]
        if isinstance(unsolved, Explanation):
            return explanation
        q = device.on_host(self.q).reshape(len(info), -1)
        return replace(explanation, collisions={**explanation.collisions, **unsolved.collisions(self.info, q)})

    @property
    def status(self) -> Status | NDArray[np.str_]:
        """The status of the search; see ``IKResult``."""
        return IKResult(self.q, self._explained[0], self._batch, self.tolerances).status

    @property
    def residual(self) -> Array:
        """The pose error by component; see ``IKResult``."""
        unsolved = self.__dict__["_unsolved"]
        return self._residual(unsolved.task_axes if isinstance(unsolved, Explanation) else unsolved.query.task_axes)

    def __reduce__(self) -> Any:
        return IKResult, (device.on_host(self.q), self._explained[0], self._batch, self.tolerances, self.explanation)


def refuse_targets(T: Any, batch: tuple[int, ...]) -> None:
    """Raise the error of a target that is no pose."""
    refuse_no_pose(device.on_host(T).reshape(*batch, 4, 4))


# ---- device code ---------------------------------------------------------------------------------------------------


@cache
def searches_of(n_dof: int):
    """The driver for robots with n_dof joints.

    A thread takes a job, searches from its starts in turn until the target is solved, and takes the next job. All threads of a
    warp take a step at the same time, whatever their targets. The result of a job does not depend on its thread.
    """
    twice, of_jacobian = 2 * n_dof, 6 * n_dof

    def searches(chain, seeds, box, samples, posture, settings, jobs, targets, q_out, info, marks):
        """Run jobs. First arguments: ``Tables``; results: one row per job; marks: the flag, and the index of the next job."""
        order, following, first, end, runs, n = jobs
        flag, counts = marks
        q_rows, last_rows = cuda.local.array((1, n_dof), np.float64), cuda.local.array((1, n_dof), np.float64)
        target_rows, bound_rows = cuda.local.array((1, 12), np.float64), cuda.local.array((1, twice), np.float64)
        state_rows, jacobian = cuda.local.array((1, N_STATE), np.float64), cuda.local.array(of_jacobian, np.float64)
        system = cuda.local.array(N_SYSTEM, np.float64)
        rows = q_rows[0], last_rows[0], target_rows[0], bound_rows[0], state_rows[0]  # as the kernels take them
        q, last, target, bound, state = q_rows.T, last_rows.T, target_rows.T, bound_rows.T, state_rows.T  # as one lane of several
        job, is_new, best = cuda.atomic.add(counts, 0, 1), True, np.inf
        i, start, until = starts_of(order, following, first, end, runs, job, n)
        while job < n:
            if is_new:
                seed = seeds[min(i, seeds.shape[0] - 1)]
                if best == np.inf:
                    info[job].status, info[job].residual_square = NOT_FOUND, np.inf
                if start == 0 and not (rigidity_defect(targets[i]) <= LARGEST_DEFECT and all_in_range(seed)):
                    info[job].status, flag[0], start = NOT_A_POSE, 1, until
                if start >= until:
                    job, best = cuda.atomic.add(counts, 0, 1), np.inf
                    i, start, until = starts_of(order, following, first, end, runs, job, n)
                    continue
                write_target(matrix_pose(targets[i]), target, 0)
                write_bounds(box, bound, 0)
                write_start(box, seed, samples, start, q, 0)
                reset_state(state, settings[0].steps, settings[0].with_posture, 0)
                is_new = False
            advance(chain, posture, settings[0], rows, (jacobian, system))
            if state[ENDED, 0] != RUNNING:
                missed, solved, is_new = state[P2, 0] + state[R2, 0], state[ENDED, 0] == HAS_SOLVED, True
                if solved or missed < best:
                    write_result((last, target, state), 0, start, job, q_out, info)
                    best = missed
                start += 1
                if solved or start == until:
                    job, best = cuda.atomic.add(counts, 0, 1), np.inf
                    i, start, until = starts_of(order, following, first, end, runs, job, n)

    return searches


@kernel
def starts_of(order, following, first, end, runs, job, n):
    """The target of a job, its first start, and the index after its last one."""
    if job >= n:
        return 0, 0, 0
    i, span = order[job // runs] if order.shape[0] > 0 else job // runs, (end - first) // runs
    start = first + (job % runs) * span
    return i, following[i] if following.shape[0] > 0 else start, start + span


def choose(jobs, q_of, info_of, hits, q, info, following, left, counts):
    """Choose the best result among a target's jobs, one target per thread; append unsolved targets to ``left``.

    q_of, info_of, hits: results of each job, and whether its q collides; q, info: results of each target; following: the first
    start of its next search. The first job with a collision-free solution wins; otherwise the first that collides; otherwise the
    nearest.
    """
    t = cuda.grid(1)
    order, _, _, end, runs, n = jobs
    if t < n // runs:
        is_first = order.shape[0] == 0
        i = t if is_first else order[t]
        chosen, collides, is_clear = -1, False, False
        for job in range(t * runs, (t + 1) * runs):
            solved = info_of[job].status == SOLVED
            hit = solved and hits.shape[0] > 0 and hits[job, 0]
            if solved and not hit:
                chosen, is_clear = job, True
                break
            if hit and not collides:
                chosen, collides = job, True
            elif not collides and (chosen < 0 or info_of[job].residual_square < info_of[chosen].residual_square):
                chosen = job
        before = NOT_FOUND if is_first else info[i].status
        following[i] = info_of[chosen].start + 1 if collides else end
        is_in_place = is_first and runs == 1  # one job per target, whose results are the target's
        if not is_in_place and (
            is_clear
            or is_first
            or (before == NOT_FOUND and (collides or info_of[chosen].residual_square < info[i].residual_square))
        ):  # fmt: skip
            for j in range(q.shape[1]):
                q[i, j] = q_of[chosen, j]
            info[i] = info_of[chosen]
        if collides and not is_clear and before == NOT_FOUND:
            info[i].status = _COLLIDES
        if not is_clear and info[i].status != NOT_A_POSE:
            left[cuda.atomic.add(counts, 1, 1)] = i


@cache
def turned_of() -> Any:
    """The driver of products of matrices (n, 4, 4) with the matrix in the tables, rows of 16."""
    return over_rows(_times, None, MATRIX)


@kernel
def _times(tables, matrix, _place, _own, out, _marks):
    """Write the product of a matrix with the matrix in the tables, row after row."""
    by = tables[0]
    for r in range(4):
        for c in range(4):
            out[4 * r + c] = matrix[r, 0] * by[0, c] + matrix[r, 1] * by[1, c] + matrix[r, 2] * by[2, c] + matrix[r, 3] * by[3, c]
    return False
