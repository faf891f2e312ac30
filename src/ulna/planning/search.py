"""Runs the search for a path and the path's shortening, in slices of checked edges."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.lanes import WIDTH
from ulna.engine.records import Records
from ulna.ik.time_limit import TimeLimit
from ulna.planning.entries import search as entries
from ulna.planning.entries.search_records import (
    CONFIRM,
    FULL,
    MAX_REFUSED,
    NO_ROOM,
    NOT_FREE,
    RRT_CONNECT,
    SHORTEN,
    SOLVED,
    SPARE_POINTS,
    WITH_COSTS,
    SearchState,
    SearchTables,
    ShorteningState,
    Trees,
)
from ulna.planning.motion import EdgeChecker, new_path, no_rows
from ulna.planning.slices import Slices

Array = NDArray[np.float64]
_FIRST_CAPACITY = 512  # nodes
_BLOCK = 1024  # samples
_NONE = 2**62
_WAYPOINTS = 384  # first capacity of a path, including spare points
_OWN_STREAM = 0x706C616E  # separates these random numbers from a caller's with the same seed


@dataclass(frozen=True)
class Effort:
    """The effort of a search.

    Attributes:
        checks: The number of checked edges.
        iterations: The number of samples that a tree was extended towards; other samples were outside the node's domain.
        start_nodes: The number of configurations in the tree of the start.
        goal_nodes: The number of configurations in the tree of the goals.
    """

    checks: int = 0
    iterations: int = 0
    start_nodes: int = 0
    goal_nodes: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """The sum of two efforts; the numbers of nodes are the maxima."""
        nodes = max(self.start_nodes, other.start_nodes), max(self.goal_nodes, other.goal_nodes)
        return Effort(self.checks + other.checks, self.iterations + other.iterations, *nodes)


class FoundPath(NamedTuple):
    """A path found by a search.

    Attributes:
        path: Its waypoints, shape (n, n_dof).
        confirmed: Whether each final edge was checked and is free.
    """

    path: Array
    confirmed: bool


@dataclass(eq=False)
class Search:
    """A bidirectional tree search, which continues with each call of ``finish``.

    Attributes:
        edges: Checks whether an edge is free.
        start: The start, shape (n_dof,).
        goals: The goals, shape (n, n_dof), at least one.
        stream: The stream of random samples: the seed, and the number of the search.
        algorithm: The number of the algorithm; an algorithm with costs needs edges from ``EdgeChecker.with_bound``.
        skip_direct: Skip the straight edges from the start to the goals, which were tried already.
        progress: Called after each slice with the number of checked edges and the maximum number.
        state: The state of the search.
        trees: The trees of the start and of the goals.
    """

    edges: EdgeChecker
    start: Array
    goals: Array
    stream: tuple[int, ...]
    algorithm: int = RRT_CONNECT
    skip_direct: bool = False
    progress: Callable[[int, int], object] | None = None
    state: SearchState = field(init=False)
    trees: Trees = field(init=False)
    _states: Records[SearchState] = field(init=False)
    _shortenings: Records[ShorteningState] = field(init=False)

    def __post_init__(self) -> None:
        n_goals, room = len(self.goals), int(self.edges.settings[0].max_nodes)
        capacity = -(-max(_FIRST_CAPACITY, 2 * (n_goals + room)) // WIDTH) * WIDTH
        self._states, self._shortenings = _first_state(n_goals, self.algorithm).copy(), ShorteningState.records()
        self.state = self._states[0]
        rows = np.empty((2, capacity // WIDTH * len(self.start), WIDTH))
        parents, radii = np.empty((2, capacity), dtype=np.int64), np.empty((2, capacity))
        parents[:, :n_goals], radii[:, :n_goals] = -1, np.inf
        costs, has_costs = no_rows((2, 0, WIDTH)), self.algorithm in WITH_COSTS
        _write_roots(self.start[None], rows[0])
        _write_roots(self.goals, rows[1])
        if self.skip_direct or has_costs:
            self.state.direct = _NONE
        if has_costs:
            costs = np.full((2, capacity // WIDTH, WIDTH), np.inf)
            costs[0, 0, 0] = 0.0
            costs[1].reshape(-1)[:n_goals] = 0.0
        self.trees = Trees(rows, parents, radii, costs, np.empty((MAX_REFUSED, 2, len(self.start))))

    def finish(self, max_checks: int, limit: TimeLimit, *, shorten: bool) -> FoundPath | None:
        """Continue the search until ``max_checks`` edges in total or the time limit; None if no path is found.

        The path is shortened, and its edges are confirmed one by one. If that fails, the path is confirmed without shortening.
        Skipped samples count as 1/64 of an edge.
        """
        found = self._run(max_checks, limit, SHORTEN if shorten else CONFIRM)
        if found is None or found.confirmed or not shorten:
            return found
        return self._run(max_checks, limit, CONFIRM)

    def _run(self, max_checks: int, limit: TimeLimit, first_pass: int) -> FoundPath | None:
        scene, settings, space, pace, keeps = self.edges
        slices = Slices(max_checks, limit, pace)
        search, shortening, n_dof = self.state, self._shortenings[0], len(self.start)
        search.max_checks = max_checks
        if search.joined:  # process the path from its beginning
            shortening.points = shortening.at = shortening.target = shortening.failures = shortening.halvings = 0
            slices.start_shortening(-int(shortening.checks))
        shortening.stage = first_pass
        path = new_path(_WAYPOINTS, n_dof, self._shortenings)
        while slices.begin_slice(shortening if search.joined else search):
            searching = not search.joined
            tables = SearchTables(settings, space.table, self._samples(), self._states)
            code = entries.plan_slice(scene, keeps, tables, self.trees, path)
            if self.progress is not None:
                self.progress(self.effort.checks, max_checks)
            if code in {SOLVED, NOT_FREE}:
                return FoundPath(path.waypoints[: shortening.points].copy(), code == SOLVED)
            if searching and search.joined:
                slices.start_shortening(int(search.checks))
            if code == FULL:
                self._grow()
            if code == NO_ROOM:
                path = new_path(2 * int(search.nodes.sum()) + SPARE_POINTS, n_dof, self._shortenings)
        return None

    @property
    def effort(self) -> Effort:
        """The effort so far, including shortening."""
        search = self.state
        return Effort(int(search.checks + self._shortenings[0].checks), int(search.iterations), *search.nodes.tolist())

    @property
    def goal(self) -> int:
        """The index of the reached goal; -1 without a path."""
        return int(self.state.goal)

    @property
    def refused(self) -> Array:
        """The last edges that were refused, at most ``MAX_REFUSED``, shape (n, 2, n_dof)."""
        return self.trees.refused[: self.state.refused]

    def _samples(self) -> Array:
        block = int(self.state.sample) // _BLOCK
        self.state.first_sample = block * _BLOCK
        return samples(len(self.start) + (self.algorithm in WITH_COSTS), self.stream, block)

    def _grow(self) -> None:
        rows, parents, radii, costs, refused = self.trees
        more = 3 * parents.shape[1]
        blocks = more // WIDTH
        rows = np.concatenate([rows, np.empty((2, blocks * len(self.start), WIDTH))], axis=1)
        parents = np.concatenate([parents, np.empty((2, more), dtype=np.int64)], axis=1)
        radii = np.concatenate([radii, np.empty((2, more))], axis=1)
        if costs.size:
            costs = np.concatenate([costs, np.full((2, blocks, WIDTH), np.inf)], axis=1)
        self.trees = Trees(rows, parents, radii, costs, refused)


@lru_cache(maxsize=64)
def _first_state(n_goals: int, algorithm: int) -> Records[SearchState]:
    """The initial state of a search, shape (1,)."""
    states = SearchState.records()
    search = states[0]
    search.nodes[:], search.active, search.goal_roots, search.goal = (1, n_goals), 1, n_goals, -1
    search.algorithm = algorithm
    return states


def _write_roots(roots: Array, rows: Array) -> None:
    """Write the roots of a tree, shape (n, n_dof), to its rows; unused lanes of their blocks are infinite."""
    blocks = rows.reshape(-1, roots.shape[1], WIDTH)
    for block in range(-(-len(roots) // WIDTH)):
        some = roots[block * WIDTH : (block + 1) * WIDTH]
        blocks[block], blocks[block, :, : len(some)] = np.inf, some.T


@lru_cache(maxsize=64)
def samples(n: int, stream: tuple[int, ...], block: int) -> Array:
    """The samples of a block, in [0, 1), shape (1024, n), determined by the stream and the block's number."""
    return np.random.default_rng([_OWN_STREAM, *stream, block]).random((_BLOCK, n))
