"""Runs the search for a path and its shortening, in slices of checked edges. Used by ``planner``."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import entry
from ulna.engine.width import WIDTH
from ulna.kernels.planning import planning_layout as layout
from ulna.planning.effort import Effort
from ulna.planning.merged_scene import MergedScene
from ulna.planning.slices import Pace, Slices
from ulna.planning.space import Space

Array = NDArray[np.float64]
_FIRST_CAPACITY = 512  # nodes
_BLOCK = 1024  # samples
_NONE = 2**62
_OWN_STREAM = 0x706C616E  # a caller who draws configurations with the same seed must not draw the same numbers


class Edges(NamedTuple):
    """What it takes to decide whether an edge is free: robot and world, ``planning_layout``'s settings, what may be moved.

    And how many of them a slice has, which is learnt.
    """

    merged: MergedScene
    settings: Array
    space: Space
    pace: Pace

    def below(self, bound: float, start: Array, goals: Array) -> "Edges":
        """The same for paths shorter than a bound: samples are taken where such a path may pass."""
        settings = self.settings.copy()
        settings[layout.BOUND] = bound
        return Edges(self.merged, settings, self.space.within(bound, start, goals), self.pace)


@dataclass(eq=False)
class Search:
    """The two trees of a search, which go on growing with each call.

    Attributes:
        edges: The robot and the world.
        start: Shape (n_dof,).
        goals: Shape (n, n_dof), at least one.
        stream: Chooses the samples: the seed, and the number of the search.
        bound: The length that the path is to stay below; then it is the search of AORRTC.
    """

    edges: Edges
    start: Array
    goals: Array
    stream: tuple[int, ...]
    bound: float = np.inf
    state: NDArray[np.int64] = field(init=False)
    _rows: list[Array] = field(init=False)
    _parents: NDArray[np.int64] = field(init=False)
    _radii: Array = field(init=False)
    _costs: Array = field(init=False)

    def __post_init__(self) -> None:
        self.state = np.zeros(layout.N_STATE, dtype=np.int64)
        n_dof, capacity = len(self.start), max(_FIRST_CAPACITY, 2 * (len(self.goals) + int(self.edges.settings[layout.ROOM])))
        capacity = -(-capacity // WIDTH) * WIDTH
        self._rows = [np.full((capacity // WIDTH * n_dof, WIDTH), np.inf) for _ in range(2)]
        self._parents, self._radii = np.full((2, capacity), -1), np.full((2, capacity), np.inf)
        for tree, roots in enumerate((self.start[None], self.goals)):
            for i, q in enumerate(roots):
                self._rows[tree][i // WIDTH * n_dof : (i // WIDTH + 1) * n_dof, i % WIDTH] = q
            self.state[tree] = len(roots)
        self.state[layout.ACTIVE], self.state[layout.GOAL_ROOTS] = 1, len(self.goals)
        self._costs = np.empty((0, WIDTH))
        if np.isfinite(self.bound):
            self.state[layout.DIRECT] = _NONE  # no straight edges: they were tried
            self._costs = np.full((2 * capacity // WIDTH, WIDTH), np.inf)
            self._costs[0, 0] = 0.0
            self._costs[capacity // WIDTH :].reshape(-1)[: len(self.goals)] = 0.0
            self.edges = self.edges.below(self.bound, self.start, self.goals)

    def run(self, max_checks: int, time_limit: float | None) -> Array | None:
        """Search on, up to so many checked edges in all or so many seconds; the path if one was found, shape (n, n_dof).

        Of the samples of which nothing comes, 64 count as one edge.
        """
        merged, settings, space, pace = self.edges
        grow, slices = entry("planning.plan_slice"), Slices(max_checks, time_limit, pace)
        no_path = np.empty((0, len(self.start)))
        self.state[layout.MOST] = max_checks
        while slices.another(self.state):
            code = grow(
                *merged.scene, merged.may_touch, settings, space.table, self._samples(),
                *self._rows, self._parents, self._radii, self._costs, no_path, self.state,
            )  # fmt: skip
            if code == layout.SOLVED:
                return self._path()
            if code == layout.FULL:
                self._grow()
        return None

    @property
    def effort(self) -> Effort:
        """What it took so far."""
        checks, iterations = self.state[layout.CHECKS], self.state[layout.ITERATIONS]
        return Effort(int(checks), int(iterations), *self.state[:2].tolist())

    @property
    def goal(self) -> int:
        """Which goal was reached."""
        node = int(self.state[layout.JOINED_GOAL])
        while self._parents[1, node] >= 0:
            node = int(self._parents[1, node])
        return node

    def _samples(self) -> Array:
        block = int(self.state[layout.SAMPLE]) // _BLOCK
        self.state[layout.FIRST_SAMPLE] = block * _BLOCK
        return samples(len(self.start) + (len(self._costs) > 0), self.stream, block)

    def _grow(self) -> None:
        more = 3 * self._parents.shape[1]
        n_dof = len(self.start)
        self._rows = [np.concatenate([rows, np.full((more // WIDTH * n_dof, WIDTH), np.inf)]) for rows in self._rows]
        self._parents = np.concatenate([self._parents, np.full((2, more), -1)], axis=1)
        self._radii = np.concatenate([self._radii, np.full((2, more), np.inf)], axis=1)
        if len(self._costs):
            infinite = np.full((more // WIDTH, WIDTH), np.inf)
            self._costs = np.concatenate([part for half in np.split(self._costs, 2) for part in (half, infinite)])

    def _path(self) -> Array:
        """From the start to a goal; the second part turned by whole turns to where the first one ends."""
        there = self._branch(0, int(self.state[layout.JOINED_START]))[::-1]
        back = self._branch(1, int(self.state[layout.JOINED_GOAL]))
        difference, direct = there[-1] - back[0], len(there) == 1 and not np.array_equal(there[-1], back[0])
        shift = difference - self.edges.space.shortest_way(difference)
        rest = back + shift if shift.any() else back
        return np.concatenate([there, rest if direct else rest[1:]])

    def _branch(self, tree: int, node: int) -> Array:
        """From a node to its root, shape (n, n_dof)."""
        nodes, n_dof = [], len(self.start)
        while node >= 0:
            nodes.append(node)
            node = int(self._parents[tree, node])
        at = np.array(nodes)
        return self._rows[tree].reshape(-1, n_dof, WIDTH)[at // WIDTH, :, at % WIDTH]


def shortened(edges: Edges, path: Array) -> tuple[Array | None, int]:
    """A shorter path, confirmed edge by edge, or None where that failed; and how many edges were checked."""
    return _run(edges, path, np.empty((0, path.shape[1])), 0)


def confirmed(edges: Edges, path: Array, spreads: Array | None = None) -> tuple[Array | None, int]:
    """The path, if each of its edges is free; else None; and how many edges were checked.

    spreads: how far beside each edge all is to be free, shape (n - 1, n_dof) [rad or m]; nowhere unless given.
    """
    return _run(edges, path, np.empty((0, path.shape[1])) if spreads is None else spreads, layout.CONFIRM)


def finished(edges: Edges, path: Array, *, shorten: bool) -> tuple[Array | None, int]:
    """A path that was found, confirmed edge by edge: shortened, or as it is where that fails; None if both do; and the checks."""
    n_checks = 0
    for attempt in (shortened, confirmed) if shorten else (confirmed,):
        found, checks = attempt(edges, path)
        n_checks += checks
        if found is not None:
            return without_repeats(found), n_checks
    return None, n_checks


def without_repeats(path: Array) -> Array:
    """The path without configurations that are the same as the one before."""
    repeats = (path[1:] == path[:-1]).all(axis=1)
    return path[np.concatenate([[True], ~repeats])] if repeats.any() else path


def _run(edges: Edges, path: Array, spreads: Array, first_pass: int) -> tuple[Array | None, int]:
    n, state = len(path), np.zeros(layout.N_STATE, dtype=np.int64)
    points = np.zeros((2 * n + 128, path.shape[1]))
    points[:n], state[layout.POINTS], state[layout.PASS] = path, n, first_pass
    plan_slice, slices, straight = entry("planning.plan_slice"), Slices(2**62, None, edges.pace), edges.space.straight
    none, known, radii = np.empty((0, path.shape[1])), np.zeros((1, len(points)), dtype=np.int64), np.empty((2, 0))
    costs = np.empty((0, WIDTH))
    while slices.another(state):
        code = plan_slice(
            *edges.merged.scene,
            edges.merged.may_touch,
            edges.settings,
            straight,
            spreads,
            none,
            none,
            known,
            radii,
            costs,
            points,
            state,
        )
        if code != layout.PAUSED:
            found = points[: state[layout.POINTS]].copy() if code == layout.SOLVED else None
            return found, int(state[layout.CHECKS])
    raise AssertionError("shortening ends by itself")


@lru_cache(maxsize=64)
def samples(n: int, stream: tuple[int, ...], block: int) -> Array:
    """The samples of a block, in [0, 1), shape (1024, n): the same in every search with that stream."""
    return np.random.default_rng([_OWN_STREAM, *stream, block]).random((_BLOCK, n))
