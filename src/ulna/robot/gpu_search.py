"""Solves inverse kinematics for many targets on a GPU, and leaves the rest to the CPU. Used by ``robot.gpu_robot``.

1. Each thread searches for a target from the seed and from random starts.
2. With a world: solutions that collide are searched again from further random starts, a few times.
3. Targets without a solution are left to the CPU, which finds one, or the reason why there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ulna.collision.world import World
from ulna.drivers.gpu.search import searches_of
from ulna.engine import gpu
from ulna.ik.explanation import NOTHING_TO_EXPLAIN, Explanation
from ulna.ik.query import Query
from ulna.ik.unit_samples import seed_sample, unit_samples
from ulna.kernels.ik import search_layout as layout
from ulna.robot.gpu_rows import Order, column_of, put_rows, rows_of

if TYPE_CHECKING:
    from ulna.robot.robot import Robot

Array = NDArray[np.float64]
_NONE = np.zeros(0, dtype=np.int64)
_STARTS = 64  # of a target in a round; those that need more are left to the CPU
_ROUNDS = 8  # for solutions that collide; then they are left to the CPU
_SEARCHES = 1 << 16  # threads that search


@dataclass(frozen=True, eq=False)
class Search:
    """A search of several targets.

    Attributes:
        robot: The robot on the CPU.
        query: The link and the options.
        seeds: Where to start, shape (n or 1, n_dof).
        seeded: Whether the caller gave them.
        world: What solutions must be clear of, if anything.
        collides: Whether configurations (k, n_dof) collide with it, or with the robot itself: bools of the host.
    """

    robot: Robot
    query: Query
    seeds: Array
    seeded: bool
    world: World | None
    collides: Callable[[Any], NDArray[np.bool_]]

    def of(self, targets: Any, batch: tuple[int, ...]) -> tuple[Any, Any, Explanation]:
        """q (n, n_dof), info (n, N_INFO) and what is known of the unsolved, for targets (n, 4, 4), NumPy's or on the device.

        Results are where the targets are.
        """
        q, info = self._round(targets, self.seeds, 0)
        if not gpu.is_on_device(targets):
            q, info = (array.copy_to_host() if gpu.is_on_device(array) else array for array in (q, info))
        solved = column_of(info, layout.STATUS) == layout.SOLVED
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
        more, its_info = (array.copy_to_host() if gpu.is_on_device(array) else array for array in there)
        its_info[:, layout.START] += k * _STARTS
        good = its_info[:, layout.STATUS] == layout.SOLVED
        good[self._colliding(more, np.flatnonzero(good))] = False
        put_rows(q, order[good], more[good])
        put_rows(info, order[good], its_info[good])
        return order[~good]

    def _seeds_of(self, order: Order) -> Array:
        return self.seeds[order] if len(self.seeds) > 1 else self.seeds

    def _round(self, targets: Any, seeds: Array, k: int) -> tuple[Any, Any]:
        """q and info of a search for each target from the starts of round k, on the device."""
        query, (n, n_dof) = self.query, (len(targets), self.robot.n_dof)
        if query.unit != 1.0 or not n:  # of arms of an unusual size the search is in a unit of its own: all is left to the CPU
            info = np.zeros((n, layout.N_INFO))
            info[:, layout.STATUS] = layout.NOT_FOUND
            q = np.zeros((n, n_dof))
            return (gpu.on_device(q), gpu.on_device(info)) if gpu.is_on_device(targets) else (q, info)
        first = [] if k else [seed_sample(n_dof)]
        random = unit_samples(query.tree, query.link, query.options.seed, max(0, k * _STARTS - 1), _STARTS - len(first))
        shared = [query.chain, seeds, query.limits[0], np.concatenate([*first, random]), query.home, query.settings]
        constants = [gpu.on_device(array) for array in shared]
        there = targets if gpu.is_on_device(targets) else gpu.on_device(targets)
        q, info = gpu.results_for(there, (n, n_dof)), gpu.results_for(there, (n, layout.N_INFO))
        following = gpu.on_device(np.zeros(1, dtype=np.int64))
        driver = gpu.compiled(searches_of(n_dof))
        driver[gpu.blocks(min(n, _SEARCHES)), gpu.THREADS](*constants, following, there, q, info, following)
        return q, info

    def _by_cpu(self, targets: Any, rest: Order, batch: tuple[int, ...], q: Any, info: Any) -> Explanation:
        """Write the results of the CPU for some targets; what is known of them."""
        if not len(rest):
            return NOTHING_TO_EXPLAIN
        options, there, seeds = self.query.options, rows_of(targets, rest), self._seeds_of(rest)
        found = self.robot.inverse_kinematics(
            there if batch else there[0], (seeds if len(seeds) > 1 else seeds[0]) if self.seeded else None, link=self.query.link,
            world=self.world, seed=options.seed, task=options.task, position_tolerance=options.position_tolerance,
            rotation_tolerance=options.rotation_tolerance,
        )  # fmt: skip
        put_rows(q, rest, found.q.reshape(len(rest), -1))
        put_rows(info, rest, found.info)
        return found.explanation.renumbered(rest)
