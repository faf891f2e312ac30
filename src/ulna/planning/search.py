"""Runs the search for a path and its shortening, in slices of checked edges."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.planning import search as driver
from ulna.engine.lanes import WIDTH
from ulna.kernels.planning import planning_layout as layout
from ulna.kernels.planning.planning_layout import Trees
from ulna.planning.motion import EdgeChecker, new_path, no_rows
from ulna.planning.slices import Slices, TimeLimit

Array = NDArray[np.float64]
_FIRST_CAPACITY = 512  # nodes
_BLOCK = 1024  # samples
_NONE = 2**62
_WAYPOINTS = 384  # with the spare ones: more are made room for when they are needed
_OWN_STREAM = 0x706C616E  # a caller who draws configurations with the same seed must not draw the same numbers


@dataclass(frozen=True)
class Effort:
    """What a search took.

    Attributes:
        checks: How many edges were checked.
        iterations: How many samples a node stepped towards; the others were outside its domain.
        start_nodes: How many configurations were reached from the start.
        goal_nodes: How many the goals were reached from.
    """

    checks: int = 0
    iterations: int = 0
    start_nodes: int = 0
    goal_nodes: int = 0

    def plus(self, other: "Effort") -> "Effort":
        """The sum of two searches; the nodes are those of the larger trees."""
        nodes = max(self.start_nodes, other.start_nodes), max(self.goal_nodes, other.goal_nodes)
        return Effort(self.checks + other.checks, self.iterations + other.iterations, *nodes)


class Found(NamedTuple):
    """A path that was found.

    Attributes:
        path: Its waypoints, shape (n, n_dof).
        confirmed: Whether each of its edges was found free as it is.
    """

    path: Array
    confirmed: bool


@dataclass(eq=False)
class Search:
    """The two trees of a search, which go on growing with each call.

    Attributes:
        edges: Decides whether an edge is free.
        start: Shape (n_dof,).
        goals: Shape (n, n_dof), at least one.
        stream: Chooses the samples: the seed, and the number of the search.
        bound: The length that the path is to stay below; if finite, the algorithm is AORRTC, else RRT-Connect.
        by_samples: Whether the straight ways from the start to the goals are left out: they were tried.
        progress: Called after each slice with the number of edges checked so far, and of all that may be.
        state: Of the search and of the shortening (``planning_layout``), shape (2, N_STATE).
        trees: The trees.
    """

    edges: EdgeChecker
    start: Array
    goals: Array
    stream: tuple[int, ...]
    bound: float = np.inf
    by_samples: bool = False
    progress: Callable[[int, int], object] | None = None
    state: NDArray[np.int64] = field(init=False)
    trees: Trees = field(init=False)

    def __post_init__(self) -> None:
        n_goals, room = len(self.goals), int(self.edges.settings[layout.ROOM] * self.edges.settings[layout.NODES_A_STEP])
        capacity = -(-max(_FIRST_CAPACITY, 2 * (n_goals + room)) // WIDTH) * WIDTH
        self.state = _first_state(n_goals).copy()
        rows = np.empty((2, capacity // WIDTH * len(self.start), WIDTH))
        parents, radii = np.empty((2, capacity), dtype=np.int64), np.empty((2, capacity))
        parents[:, :n_goals], radii[:, :n_goals] = -1, np.inf
        costs = no_rows((2, 0, WIDTH))
        _write_roots(self.start[None], rows[0])
        _write_roots(self.goals, rows[1])
        if self.by_samples or self.bound < np.inf:
            self.state[0, layout.DIRECT] = _NONE
        if self.bound < np.inf:
            self.state[0, layout.ALGORITHM] = layout.AORRTC
            costs = np.full((2, capacity // WIDTH, WIDTH), np.inf)
            costs[0, 0, 0] = 0.0
            costs[1].reshape(-1)[:n_goals] = 0.0
            self.edges = self.edges.below(self.bound, self.start, self.goals)
        self.trees = Trees(rows, parents, radii, costs, np.empty((layout.MOST_REFUSED, 2, len(self.start))))

    def finish(self, max_checks: int, limit: TimeLimit, *, shorten: bool) -> Found | None:
        """Search on, up to so many checked edges in all or until the time is over; None if there is no path.

        A path is confirmed edge by edge: shortened, or as it is where that fails. Of the samples that are skipped, 64 count as
        one edge.
        """
        found = self._found(max_checks, limit, layout.SHORTEN if shorten else layout.CONFIRM)
        if found is None or found.confirmed or not shorten:
            return found
        return self._found(max_checks, limit, layout.CONFIRM)

    def _found(self, max_checks: int, limit: TimeLimit, first_pass: int) -> Found | None:
        scene, settings, space, pace, keeps = self.edges
        slices = Slices(max_checks, limit, pace)
        search, shortening = self.state
        search[layout.MOST] = max_checks
        if search[layout.JOINED]:  # the path is made ready again
            shortening[layout.POINTS] = shortening[layout.AT] = shortening[layout.OTHER] = 0
            slices.go_over(-int(shortening[layout.CHECKS]))
        shortening[layout.PASS] = first_pass
        n_dof = len(self.start)
        path = new_path(_WAYPOINTS, n_dof)
        while slices.another(shortening if search[layout.JOINED] else search):
            searching = not search[layout.JOINED]
            code = driver.plan_slice(*scene, keeps, settings, space.table, self._samples(), *self.trees, *path, self.state)
            if self.progress is not None:
                self.progress(self.effort.checks, max_checks)
            if code in {layout.SOLVED, layout.NOT_FREE}:
                return Found(path.waypoints[: shortening[layout.POINTS]].copy(), code == layout.SOLVED)
            if searching and search[layout.JOINED]:
                slices.go_over(int(search[layout.CHECKS]))
            if code == layout.FULL:
                self._grow()
            if code == layout.NO_ROOM:
                path = new_path(2 * int(search[layout.STARTS] + search[layout.GOALS]) + layout.SPARE_POINTS, n_dof)
        return None

    @property
    def effort(self) -> Effort:
        """What it took so far, the shortening too."""
        search = self.state[0].tolist()
        return Effort(search[layout.CHECKS] + int(self.state[1, layout.CHECKS]), search[layout.ITERATIONS], *search[:2])

    @property
    def goal(self) -> int:
        """Which goal was reached, -1 without a path."""
        return int(self.state[0, layout.GOAL_REACHED])

    @property
    def refused(self) -> Array:
        """The last edges that were not free, at most ``MOST_REFUSED``, shape (n, 2, n_dof)."""
        return self.trees.refused[: self.state[0, layout.REFUSED]]

    def _samples(self) -> Array:
        block = int(self.state[0, layout.SAMPLE]) // _BLOCK
        self.state[0, layout.FIRST_SAMPLE] = block * _BLOCK
        return samples(len(self.start) + (self.bound < np.inf), self.stream, block)

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
def _first_state(n_goals: int) -> NDArray[np.int64]:
    """The state of a search that has not begun."""
    state = np.zeros((2, layout.N_STATE), dtype=np.int64)
    search = state[0]
    search[:2], search[layout.ACTIVE], search[layout.GOAL_ROOTS] = (1, n_goals), 1, n_goals
    search[layout.GOAL_REACHED] = -1
    return state


def _write_roots(roots: Array, rows: Array) -> None:
    """Write the roots of a tree, shape (n, n_dof), to its rows; the other lanes of their blocks are infinite."""
    blocks = rows.reshape(-1, roots.shape[1], WIDTH)
    for block in range(-(-len(roots) // WIDTH)):
        some = roots[block * WIDTH : (block + 1) * WIDTH]
        blocks[block], blocks[block, :, : len(some)] = np.inf, some.T


@lru_cache(maxsize=64)
def samples(n: int, stream: tuple[int, ...], block: int) -> Array:
    """The samples of a block, in [0, 1), shape (1024, n): equal in every search with that stream."""
    return np.random.default_rng([_OWN_STREAM, *stream, block]).random((_BLOCK, n))
