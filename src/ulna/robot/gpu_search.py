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

if TYPE_CHECKING:
    from ulna.robot.robot import Robot

Array = NDArray[np.float64]
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
        collides: Whether configurations (k, n_dof) collide with it, or with the robot itself.
    """

    robot: Robot
    query: Query
    seeds: Array
    seeded: bool
    world: World | None
    collides: Callable[[Array], NDArray[np.bool_]]

    def of(self, targets: Any, batch: tuple[int, ...]) -> tuple[Array, Array, Explanation]:
        """q (n, n_dof), info (n, N_INFO) and what is known of the unsolved, for targets (n, 4, 4), NumPy's or on the device."""
        q, info = self._round(targets, self.seeds, 0)
        solved = info[:, layout.STATUS] == layout.SOLVED
        colliding = self._colliding(q, np.flatnonzero(solved)) if self.world is not None else np.flatnonzero(~solved)[:0]
        if solved.all() and not len(colliding):
            return q, info, NOTHING_TO_EXPLAIN
        on_host = targets.copy_to_host() if gpu.is_on_device(targets) else targets
        for k in range(1, _ROUNDS):
            if len(colliding):
                colliding = self._again(on_host, colliding, k, q, info)
        rest = np.sort(np.append(np.flatnonzero(~solved), colliding))
        return q, info, self._by_cpu(on_host, rest, batch, q, info)

    def _colliding(self, q: Array, order: NDArray[np.int64]) -> NDArray[np.int64]:
        """Those of some configurations that collide."""
        return order[self.collides(q[order])] if len(order) else order

    def _again(self, targets: Array, order: NDArray[np.int64], k: int, q: Array, info: Array) -> NDArray[np.int64]:
        """Search for some targets from the starts of round k; those that still have no solution that is clear."""
        more, its_info = self._round(targets[order], self._seeds_of(order), k)
        good = its_info[:, layout.STATUS] == layout.SOLVED
        good[self._colliding(more, np.flatnonzero(good))] = False
        q[order[good]], info[order[good]] = more[good], its_info[good]
        return order[~good]

    def _seeds_of(self, order: NDArray[np.int64]) -> Array:
        return self.seeds[order] if len(self.seeds) > 1 else self.seeds

    def _round(self, targets: Any, seeds: Array, k: int) -> tuple[Array, Array]:
        """q and info of a search for each target from the starts of round k, on the host."""
        query, (n, n_dof) = self.query, (len(targets), self.robot.n_dof)
        q, info = np.zeros((n, n_dof)), np.zeros((n, layout.N_INFO))
        info[:, layout.STATUS] = layout.NOT_FOUND
        if query.unit != 1.0 or not n:
            return q, info  # of arms of an unusual size the search is in a unit of its own: all is left to the CPU
        first = [] if k else [seed_sample(n_dof)]
        random = unit_samples(query.tree, query.link, query.options.seed, max(0, k * _STARTS - 1), _STARTS - len(first))
        shared = [query.chain, seeds, query.limits[0], np.concatenate([*first, random]), query.home, query.settings]
        constants = [gpu.on_device(array) for array in shared]
        there = targets if gpu.is_on_device(targets) else gpu.on_device(targets)
        q_there, info_there, following = gpu.on_device(q), gpu.on_device(info), gpu.on_device(np.zeros(1, dtype=np.int64))
        driver = gpu.compiled(searches_of(n_dof))
        driver[gpu.blocks(min(n, _SEARCHES)), gpu.THREADS](*constants, following, there, q_there, info_there, following)
        info = info_there.copy_to_host()
        info[:, layout.START] += k * _STARTS
        return q_there.copy_to_host(), info

    def _by_cpu(self, targets: Array, rest: NDArray[np.int64], batch: tuple[int, ...], q: Array, info: Array) -> Explanation:
        """Write the results of the CPU for some targets; what is known of them."""
        if not len(rest):
            return NOTHING_TO_EXPLAIN
        options, there, seeds = self.query.options, targets[rest], self._seeds_of(rest)
        found = self.robot.inverse_kinematics(
            there if batch else there[0], (seeds if len(seeds) > 1 else seeds[0]) if self.seeded else None, self.query.link,
            world=self.world, seed=options.seed, task=options.task, position_tolerance=options.position_tolerance,
            rotation_tolerance=options.rotation_tolerance,
        )  # fmt: skip
        q[rest], info[rest] = found.q, found.info
        return found.explanation.renumbered(rest)
