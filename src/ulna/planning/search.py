"""Runs the search for a path and its shortening, in slices of checked edges."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers import planning
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.planning.plan_status import Effort
from ulna.planning.slices import Pace, Slices
from ulna.planning.space import Space

Array = NDArray[np.float64]
_FIRST_CAPACITY = 512  # nodes
_BLOCK = 1024  # samples
_NONE = 2**62
_POINTS = 384  # of a path, with the spare ones: more are made room for when they are needed
_SHORTEN = 0  # the first pass of shortening
_OWN_STREAM = 0x706C616E  # a caller who draws configurations with the same seed must not draw the same numbers


class Edges(NamedTuple):
    """What it takes to decide whether an edge is free: robot and world, ``planning_layout``'s settings, what may be moved.

    And how many of them a slice has, which is learnt.
    """

    scene: Scene
    settings: Array
    space: Space
    pace: Pace

    def below(self, bound: float, start: Array, goals: Array) -> "Edges":
        """The same for paths shorter than a bound: samples are taken where such a path may pass."""
        settings = self.settings.copy()
        settings[layout.BOUND] = bound
        return Edges(self.scene, settings, self.space.within(bound, start, goals), self.pace)


class Found(NamedTuple):
    """A path that was found.

    Attributes:
        path: Its points, shape (n, n_dof).
        confirmed: Whether each of its edges was found free as it is.
        checks: How many edges were checked for that, and to shorten it.
    """

    path: Array
    confirmed: bool
    checks: int


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
        n_goals, room = len(self.goals), int(self.edges.settings[layout.ROOM])
        capacity = -(-max(_FIRST_CAPACITY, 2 * (n_goals + room)) // WIDTH) * WIDTH
        self.state = _first_state(n_goals).copy()
        self._rows = [_tree_of(roots, capacity) for roots in (self.start[None], self.goals)]
        self._parents, self._radii = np.empty((2, capacity), dtype=np.int64), np.empty((2, capacity))
        self._parents[:, :n_goals], self._radii[:, :n_goals] = -1, np.inf
        self._costs = _nothing(WIDTH)
        if self.bound < np.inf:
            self.state[0, layout.DIRECT] = _NONE  # no straight edges: they were tried
            self._costs = np.full((2 * capacity // WIDTH, WIDTH), np.inf)
            self._costs[0, 0] = 0.0
            self._costs[capacity // WIDTH :].reshape(-1)[:n_goals] = 0.0
            self.edges = self.edges.below(self.bound, self.start, self.goals)

    def run(self, max_checks: int, time_limit: float | None) -> Array | None:
        """Search on, up to so many checked edges in all or so many seconds; the path if one was found, shape (n, n_dof).

        Of the samples of which nothing comes, 64 count as one edge.
        """
        found = self._found(max_checks, time_limit, layout.AS_FOUND)
        return None if found is None else found.path

    def finish(self, max_checks: int, time_limit: float | None, *, shorten: bool) -> Found | None:
        """The same, and the path confirmed edge by edge: shortened, or as it is where that fails; None if there is no path."""
        found = self._found(max_checks, time_limit, _SHORTEN if shorten else layout.CONFIRM)
        if found is None or found.confirmed or not shorten:
            return found
        return self._found(max_checks, time_limit, layout.CONFIRM)

    def _found(self, max_checks: int, time_limit: float | None, first_pass: int) -> Found | None:
        scene, settings, space, pace = self.edges
        slices = Slices(max_checks, time_limit, pace)
        search, shortening = self.state
        search[layout.MOST] = max_checks
        if search[layout.JOINED]:  # the path is made ready again
            shortening[layout.POINTS] = shortening[layout.AT] = shortening[layout.OTHER] = 0
            slices.go_over(-int(shortening[layout.CHECKS]))
        shortening[layout.PASS] = first_pass
        n_dof = len(self.start)
        path, known, none = np.empty((_POINTS, n_dof)), np.zeros((1, _POINTS), dtype=np.int64), _nothing(n_dof)
        while slices.another(shortening if search[layout.JOINED] else search):
            searching = not search[layout.JOINED]
            code = planning.plan_slice(
                *scene, settings, space.table, self._samples(),
                self._rows[0], self._rows[1], self._parents, self._radii, self._costs, none, path, known, self.state,
            )  # fmt: skip
            if code in {layout.SOLVED, layout.NOT_FREE}:
                points = path[: shortening[layout.POINTS]].copy()
                return Found(points, code == layout.SOLVED, int(shortening[layout.CHECKS]))
            if searching and search[layout.JOINED]:
                slices.go_over(int(search[layout.CHECKS]))
            if code == layout.FULL:
                self._grow()
            if code == layout.NO_ROOM:
                n = 2 * int(search[layout.STARTS] + search[layout.GOALS]) + layout.SPARE_POINTS
                path, known = np.empty((n, n_dof)), np.zeros((1, n), dtype=np.int64)
        return None

    @property
    def effort(self) -> Effort:
        """What it took so far, the shortening too."""
        search = self.state[0].tolist()
        return Effort(search[layout.CHECKS] + int(self.state[1, layout.CHECKS]), search[layout.ITERATIONS], *search[:2])

    @property
    def goal(self) -> int:
        """Which goal was reached."""
        return int(self.state[0, layout.REACHED])

    def _samples(self) -> Array:
        block = int(self.state[0, layout.SAMPLE]) // _BLOCK
        self.state[0, layout.FIRST_SAMPLE] = block * _BLOCK
        return samples(len(self.start) + (len(self._costs) > 0), self.stream, block)

    def _grow(self) -> None:
        more = 3 * self._parents.shape[1]
        n_dof = len(self.start)
        self._rows = [np.concatenate([rows, np.empty((more // WIDTH * n_dof, WIDTH))]) for rows in self._rows]
        self._parents = np.concatenate([self._parents, np.empty((2, more), dtype=np.int64)], axis=1)
        self._radii = np.concatenate([self._radii, np.empty((2, more))], axis=1)
        if len(self._costs):
            infinite = np.full((more // WIDTH, WIDTH), np.inf)
            self._costs = np.concatenate([part for half in np.split(self._costs, 2) for part in (half, infinite)])


@lru_cache(maxsize=64)
def _first_state(n_goals: int) -> NDArray[np.int64]:
    """The state of a search that has not begun."""
    state = np.zeros((2, layout.N_STATE), dtype=np.int64)
    search = state[0]
    search[:2], search[layout.ACTIVE], search[layout.GOAL_ROOTS] = (1, n_goals), 1, n_goals
    return state


def _tree_of(roots: Array, capacity: int) -> Array:
    """Room for a tree (``kernels.planning.space``), with its roots, shape (n, n_dof); the others of their blocks infinite."""
    n, n_dof = roots.shape
    rows = np.empty((capacity // WIDTH, n_dof, WIDTH))
    for block in range(-(-n // WIDTH)):
        some = roots[block * WIDTH : (block + 1) * WIDTH]
        rows[block], rows[block, :, : len(some)] = np.inf, some.T
    return rows.reshape(-1, WIDTH)


@lru_cache(maxsize=64)
def _nothing(width: int) -> Array:
    """An array without rows."""
    return np.empty((0, width))


def shortened(edges: Edges, path: Array) -> tuple[Array | None, int]:
    """A shorter path, confirmed edge by edge, or None where that failed; and how many edges were checked."""
    return _run(edges, path, _nothing(path.shape[1]), _SHORTEN)


def confirmed(edges: Edges, path: Array, spreads: Array | None = None) -> tuple[Array | None, int]:
    """The path, if each of its edges is free; else None; and how many edges were checked.

    spreads: how far beside each edge all is to be free, shape (n - 1, n_dof) [rad or m]; nowhere unless given.
    """
    return _run(edges, path, _nothing(path.shape[1]) if spreads is None else spreads, layout.CONFIRM)


def _run(edges: Edges, path: Array, spreads: Array, first_pass: int) -> tuple[Array | None, int]:
    n, state = len(path), np.zeros((2, layout.N_STATE), dtype=np.int64)
    points, shortening = np.empty((2 * n + layout.SPARE_POINTS, path.shape[1])), state[1]
    points[:n], shortening[layout.POINTS], shortening[layout.PASS], shortening[layout.ROWS] = path, n, first_pass, len(points)
    slices = Slices(2**62, None, edges.pace)
    none, known, radii = _nothing(path.shape[1]), np.zeros((1, len(points)), dtype=np.int64), _nothing(0)
    while slices.another(shortening):
        code = planning.plan_slice(
            *edges.scene, edges.settings, edges.space.table, none,
            none, none, known, radii, _nothing(WIDTH), spreads, points, known, state,
        )  # fmt: skip
        if code != layout.PAUSED:
            found = points[: shortening[layout.POINTS]].copy() if code == layout.SOLVED else None
            return found, int(shortening[layout.CHECKS])
    raise AssertionError("shortening ends by itself")


@lru_cache(maxsize=64)
def samples(n: int, stream: tuple[int, ...], block: int) -> Array:
    """The samples of a block, in [0, 1), shape (1024, n): the same in every search with that stream."""
    return np.random.default_rng([_OWN_STREAM, *stream, block]).random((_BLOCK, n))
