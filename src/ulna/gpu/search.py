"""Solves inverse kinematics for many targets on a GPU, and leaves the rest to the CPU.

1. Each thread searches for a target by Levenberg-Marquardt, from the seed and from random starts.
2. With a world: solutions that collide are searched again from further random starts, a few times.
3. Targets without a solution are left to the CPU, which finds one, or the reason why there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.gpu.rows import Order, put_records, put_rows, rows_of
from ulna.ik.entries.lane_state import reset_state, write_bounds, write_result, write_start, write_target
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import Request
from ulna.ik.problem import Query, of_task
from ulna.ik.reason import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.result import IKResult
from ulna.ik.search.starts import unit_samples
from ulna.kernels.ik.levenberg_marquardt import ENDED, HAS_SOLVED, N_STATE, P2, R2, RUNNING, advance
from ulna.kernels.ik.search_layout import N_SYSTEM, NOT_A_POSE, NOT_FOUND, SOLVED
from ulna.kernels.ik.search_records import Results, SearchResult
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import matrix_pose, rigidity_defect
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
_NONE = np.zeros(0, dtype=np.int64)
_STARTS = 64  # of a target in a round; those that need more are left to the CPU
_ROUNDS = 8  # for solutions that collide; then they are left to the CPU
_SEARCHES = 1 << 16  # threads that search


class OnHost(Protocol):
    """What is used here of a robot on the CPU: ``robot`` is above this folder, and makes a ``GpuRobot`` of itself."""

    tree: Tree
    """Its tree in flat arrays."""
    home: Array
    """The configuration to start from [rad or m], shape (n_dof,)."""
    _checker: Checker
    _inverse_kinematics: InverseKinematics


@dataclass(frozen=True, eq=False)
class DeviceSearch:
    """A search of several targets.

    Attributes:
        on_host: What solves the rest.
        query: The link and the options.
        seeds: Where to start, shape (n or 1, n_dof).
        seeded: Whether the caller gave them.
        world: What solutions must be clear of, if anything.
        collides: Whether configurations (k, n_dof) collide with it, or with the robot itself: bools of the host.
    """

    on_host: InverseKinematics
    query: Query
    seeds: Array
    seeded: bool
    world: World | None
    collides: Callable[[Any], NDArray[np.bool_]]

    def of(self, targets: Any, batch: tuple[int, ...]) -> tuple[Any, Any, Explanation]:
        """q (n, n_dof), info (n,) and what is known of the unsolved, for targets (n, 4, 4), NumPy's or on the device.

        Results are where the targets are.
        """
        q, info = self._round(targets, self.seeds, 0)
        if not device.is_on_device(targets):
            q, info = (array.copy_to_host() if device.is_on_device(array) else array for array in (q, info))
        solved = _statuses(info) == SOLVED
        colliding = _NONE if self.world is None else self._colliding(q, np.flatnonzero(solved))
        if solved.all() and not len(colliding):
            return q, info, NOTHING_TO_EXPLAIN
        for k in range(1, _ROUNDS):
            if len(colliding):
                colliding = self._again(targets, colliding, k, q, info)
        rest = np.sort(np.append(np.flatnonzero(~solved), colliding))
        return q, info, self._by_cpu(targets, rest, batch, q, info)

    def _colliding(self, q: Any, order: Order) -> Order:
        """Those of some configurations that collide."""
        some = q if len(order) == len(q) else rows_of(q, order)
        return order[self.collides(some)] if len(order) else order

    def _again(self, targets: Any, order: Order, k: int, q: Any, info: Any) -> Order:
        """Search for some targets from the starts of round k; those that still have no solution that is clear."""
        there = self._round(rows_of(targets, order), self._seeds_of(order), k)
        more, its_info = (array.copy_to_host() if device.is_on_device(array) else array for array in there)
        its_info["start"] += k * _STARTS
        good = its_info["status"] == SOLVED
        good[self._colliding(more, np.flatnonzero(good))] = False
        put_rows(q, order[good], more[good])
        put_records(info, order[good], its_info[good])
        return order[~good]

    def _seeds_of(self, order: Order) -> Array:
        return self.seeds[order] if len(self.seeds) > 1 else self.seeds

    def _round(self, targets: Any, seeds: Array, k: int) -> tuple[Any, Any]:
        """q and info of a search for each target from the starts of round k, on the device."""
        query, (n, n_dof) = self.query, (len(targets), self.query.tree.n_dof)
        if query.unit != 1.0 or not n:  # of arms of an unusual size the search is in a unit of its own: all is left to the CPU
            info = np.zeros(n, SearchResult.structure)
            info["status"] = NOT_FOUND
            q = np.zeros((n, n_dof))
            return (device.on_device(q), device.on_device(info)) if device.is_on_device(targets) else (q, info)
        first = max(0, k * _STARTS - 1)
        starts = unit_samples(query.tree, query.link, query.options.seed, first, _STARTS, from_seed=not k)
        shared = [query.chain, seeds, query.limits[0], starts, query.home, query.settings]
        constants = [device.on_device(array) for array in shared]
        if query.task_axes is not None:
            targets = of_task(query, targets.copy_to_host() if device.is_on_device(targets) else targets)
        there = targets if device.is_on_device(targets) else device.on_device(targets)
        q, info = device.results_for(there, (n, n_dof)), device.results_for(there, (n,), SearchResult.structure)
        following = device.on_device(np.zeros(1, dtype=np.int64))
        driver = device.compiled(searches_of(n_dof))
        driver[device.blocks(min(n, _SEARCHES)), device.THREADS](*constants, following, there, q, info, following)
        return q, info

    def _by_cpu(self, targets: Any, rest: Order, batch: tuple[int, ...], q: Any, info: Any) -> Explanation:
        """Write the results of the CPU for some targets; what is known of them."""
        if not len(rest):
            return NOTHING_TO_EXPLAIN
        there, seeds = rows_of(targets, rest), self._seeds_of(rest)
        targets, seed = there if batch else there[0], (seeds if len(seeds) > 1 else seeds[0]) if self.seeded else None
        asked = Request(targets, seed, world=self.world, link=self.query.link, options=self.query.options)
        found = self.on_host.inverse_kinematics(asked)
        put_rows(q, rest, found.q.reshape(len(rest), -1))
        put_records(info, rest, found.info)
        return found.explanation.renumbered(rest)


class DeviceResult(IKResult):
    """An ``IKResult`` whose q is on the device; all else is copied to the host when it is first asked for."""

    def __init__(
        self,
        q: Any,
        info: Any,
        batch: tuple[int, ...],
        tolerances: tuple[float, float],
        explanation: Explanation = NOTHING_TO_EXPLAIN,
    ) -> None:
        known = {"q": q, "_there": info, "_batch": batch, "tolerances": tolerances, "explanation": explanation}
        for name, value in known.items():
            object.__setattr__(self, name, value)

    @cached_property
    def info(self) -> Results:  # pyright: ignore[reportIncompatibleVariableOverride] - it is as read-only
        """The result for each target."""
        return self.__dict__["_there"].copy_to_host()

    def __reduce__(self) -> Any:
        q: Any = self.q
        return IKResult, (q.copy_to_host(), self.info, self._batch, self.tolerances, self.explanation)


def _statuses(info: Any) -> NDArray[np.int64]:
    """The statuses of results, on the host."""
    if not device.is_on_device(info):
        return info["status"]
    out = cuda.device_array(len(info), np.int64)
    device.compiled(_write_statuses)[device.blocks(len(info)), device.THREADS](info, out)
    return out.copy_to_host()


def _write_statuses(info, out):
    """Write the statuses of results (n,) to out (n,), one a thread."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        out[i] = info[i].status


@cache
def searches_of(n_dof: int):
    """The driver for robots of so many joints.

    A thread takes a target, searches from one start after the other until it is solved, and takes the next target. All threads of
    a warp take a step at the same time, whatever targets they have. The result of a target does not depend on its thread.
    """
    twice, of_jacobian = 2 * n_dof, 6 * n_dof

    def searches(chain, seeds, box, samples, posture, settings, following, targets, q_out, info, _):
        """The arguments are those of ``ik.entries.multi_start``; ``following``: the number of the next target, shape (1,)."""
        q_rows, last_rows = cuda.local.array((1, n_dof), np.float64), cuda.local.array((1, n_dof), np.float64)
        target_rows, bound_rows = cuda.local.array((1, 12), np.float64), cuda.local.array((1, twice), np.float64)
        state_rows, jacobian = cuda.local.array((1, N_STATE), np.float64), cuda.local.array(of_jacobian, np.float64)
        system = cuda.local.array(N_SYSTEM, np.float64)
        rows = q_rows[0], last_rows[0], target_rows[0], bound_rows[0], state_rows[0]  # as the kernels take them
        q, last, target, bound, state = q_rows.T, last_rows.T, target_rows.T, bound_rows.T, state_rows.T  # as one lane of several
        start, is_new, best = 0, True, np.inf
        i = cuda.atomic.add(following, 0, 1)
        while i < targets.shape[0]:
            seed = seeds[min(i, seeds.shape[0] - 1)]
            if start == 0 and is_new and not (rigidity_defect(targets[i]) <= LARGEST_DEFECT and all_in_range(seed)):
                info[i].status = NOT_A_POSE
                i = cuda.atomic.add(following, 0, 1)
                continue
            if is_new:
                if start == 0:
                    best, info[i].status = np.inf, NOT_FOUND
                write_target(matrix_pose(targets[i]), target, 0)
                write_bounds(box, bound, 0)
                write_start(box, seed, samples, start, q, 0)
                reset_state(state, settings[0].steps, settings[0].with_posture, 0)
                is_new = False
            advance(chain, posture, settings[0], rows, (jacobian, system))
            if state[ENDED, 0] != RUNNING:
                missed, solved = state[P2, 0] + state[R2, 0], state[ENDED, 0] == HAS_SOLVED
                if solved or missed < best:
                    write_result(last, target, state, 0, start, i, q_out, info)
                    best = missed
                start, is_new = start + 1, True
                if solved or start == samples.shape[0]:
                    start, i = 0, cuda.atomic.add(following, 0, 1)

    return searches
