"""Checks whether edges are free and satisfy constraints, for a search and for whole paths."""

from functools import lru_cache
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.object_tables import NO_OBJECTS
from ulna.collision.objects import Objects
from ulna.collision.world import World
from ulna.dynamics.dynamics import Dynamics
from ulna.engine.lanes import WIDTH
from ulna.engine.records import Records
from ulna.ik.time_limit import TimeLimit
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning.constraint_records import Constraints
from ulna.planning.blend import CHORDS_ALONG, Certificate, is_path_free
from ulna.planning.constraint_table import freeze, max_step, min_tolerance, shrink_tolerances
from ulna.planning.edge_subdivision import TIGHT, subdivide
from ulna.planning.entries import search as entries
from ulna.planning.entries.search_records import (
    CONFIRM,
    PAUSED,
    SHORTEN,
    SOLVED,
    SPARE_POINTS,
    Path,
    SearchSettings,
    SearchState,
    SearchTables,
    ShorteningState,
    Trees,
    search_settings,
)
from ulna.planning.positions import PositionLimits, farthest_of
from ulna.planning.slices import Pace, Slices
from ulna.planning.space import Space

Array = NDArray[np.float64]


class EdgeChecker(NamedTuple):
    """A checker of edges and paths.

    Attributes:
        scene: The robot and the world.
        settings: The settings of a search, one read-only record.
        space: The configuration space.
        pace: The number of edges per slice.
        keeps: The constraints (``constraint_table.make_constraint_table``), or None.
    """

    scene: Scene
    settings: Records[SearchSettings]
    space: Space
    pace: Pace
    keeps: Constraints | None

    def with_bound(self, bound: float, start: Array, goals: Array) -> "EdgeChecker":
        """A copy for paths shorter than a bound: samples are limited to where such a path can pass."""
        settings = self.settings.copy()
        settings[0].bound = bound
        settings.setflags(write=False)
        return self._replace(settings=settings, space=self.space.with_bound(bound, start, goals))

    def checked(self, waypoints: Array, *, shorten: bool = False) -> Array | None:
        """Check a path, shape (n, n_dof): return it, shortened if asked, if each edge is free; else None."""
        return self.check_and_count(waypoints, shorten=shorten)[0]

    def check_and_count(self, waypoints: Array, *, shorten: bool = False) -> tuple[Array | None, int]:
        """The result of ``checked``, and the number of checked edges."""
        path = _path_of(waypoints, no_rows((0, waypoints.shape[1])), SHORTEN if shorten else CONFIRM)
        found = path.waypoints[: path.state[0].points].copy() if self._ends_free(path) else None
        return found, int(path.state[0].checks)

    def n_free(self, paths: Array, spreads: Array) -> int:
        """The number of paths, counted from the first, that are free; see ``blend.Certificate``."""
        m, n, n_dof = paths.shape
        beside = np.zeros((m, n, n_dof))
        beside[:, :-1] = spreads
        path = _path_of(paths.reshape(m * n, n_dof), beside.reshape(m * n, n_dof), CONFIRM)
        path.known[n - 1 : m * n : n] = 1  # edges that join the end of a path to the next start
        return m if self._ends_free(path) else int(path.state[0].at - 1) // n

    def _ends_free(self, path: Path) -> bool:
        """Check a path, with shortening if its state requests this; True if each of its edges is free."""
        samples, slices = no_rows((0, path.waypoints.shape[1])), Slices(2**62, TimeLimit(None), self.pace)
        tables = SearchTables(self.settings, self.space.table, samples, SearchState.records())
        while slices.begin_slice(path.state[0]):
            code = entries.plan_slice(self.scene, self.keeps, tables, _no_trees(), path)
            if code != PAUSED:
                return code == SOLVED
        raise AssertionError("shortening ends by itself")


class Motion(NamedTuple):
    """The problem that a plan or a trajectory was computed for, with which its edges can be checked again.

    Attributes:
        space: The configuration space, with its metric.
        checker: The robot's collision checker.
        world: A copy of the world at planning time.
        margin: The minimum distance from objects [m].
        keeps: The constraints (``constraint_table.make_constraint_table``), or None.
        dynamics: The robot's dynamics, for torques.
    """

    space: Space
    checker: Checker
    world: World | None
    margin: float
    keeps: Constraints | None = None
    dynamics: Dynamics | None = None

    def edges(self, *, certify: bool) -> EdgeChecker:
        """A checker of edges, certified or at samples, with constraints of slightly smaller tolerances."""
        objects, kept = NO_OBJECTS if self.world is None else self.world.objects(), _last_scenes.get(self.checker)
        if kept is None or kept[0] is not objects:
            kept = _last_scenes[self.checker] = objects, self.checker.scene_of(self.world, self_collision=True), Pace()
        longest, keeps = (np.inf, None) if self.keeps is None else (max_step(self.keeps), shrink_tolerances(self.keeps))
        settings = search_settings(self.space.n_moving, self.space.diameter, self.margin, longest, certify=certify)
        return EdgeChecker(kept[1], settings, self.space, kept[2], keeps)

    def is_free(self, points: Array, spreads: Array) -> bool:
        """Whether a path, shape (n, n_dof), is certified to be free and to satisfy the constraints.

        The certificate covers all configurations within ``spreads``, shape (n - 1, n_dof), of its edges.
        """
        return is_path_free(self.certificate, points, spreads)

    @property
    def certificate(self) -> Certificate:
        """The certificate of paths, with enough chords per rounded corner for the constraints."""
        return (
            Certificate(self.n_free) if self.keeps is None else Certificate(self.n_free, CHORDS_ALONG, min_tolerance(self.keeps))
        )

    def subdivide(self, path: Array, positions: PositionLimits) -> Array:
        """A path, shape (n, n_dof), subdivided along tight constraints to use less of their tolerances, if that is free."""
        if self.keeps is None or min_tolerance(self.keeps) > TIGHT:
            return path
        points = subdivide(path, self.keeps, self.checker.tree, self.space)
        inside = positions.beyond_of(farthest_of(points, np.arange(float(len(points))))) is None
        return points if inside and self.is_free(points, np.zeros_like(points[1:])) else path

    def n_free(self, paths: Array, spreads: Array) -> int:
        """The number of paths, counted from the first, that are certified; see ``blend.Certificate``."""
        if self.keeps is not None:
            freeze(self.keeps)  # unpickled arrays are writable: kernels would be compiled again for their type
        return self.edges(certify=True)._replace(keeps=self.keeps).n_free(paths, spreads)

    def clearance(self, q: Array) -> float:
        """The least distance of the robot at q, shape (n, n_dof), from an object [m]; infinite without objects."""
        if self.world is None or not self.world.names:
            return np.inf
        return float(np.min(self.checker.signed_distance(q, self.world, self_collision=False)))


_last_scenes: WeakKeyDictionary[Checker, tuple[Objects, Scene, Pace]] = WeakKeyDictionary()  # each robot's last world


def new_path(capacity: int, n_dof: int, state: Records[ShorteningState]) -> Path:
    """An empty path with room for ``capacity`` points and no checked edges."""
    return Path(np.empty((capacity, n_dof)), np.zeros(capacity, dtype=np.int64), no_rows((0, n_dof)), state)


def _path_of(waypoints: Array, spreads: Array, first_pass: int) -> Path:
    """A path to check, from its points, shape (n, n_dof)."""
    n, n_dof = waypoints.shape
    path = new_path(2 * n + SPARE_POINTS, n_dof, ShorteningState.records())._replace(spreads=spreads)
    path.waypoints[:n], state = waypoints, path.state[0]
    state.points, state.stage, state.capacity = n, first_pass, len(path.waypoints)
    return path


@lru_cache(maxsize=64)
def no_rows(shape: tuple[int, ...]) -> Array:
    """An array without elements; cached."""
    return np.empty(shape)


@lru_cache(maxsize=1)
def _no_trees() -> Trees:
    return Trees(
        no_rows((2, 0, WIDTH)), np.empty((2, 0), dtype=np.int64), no_rows((2, 0)), no_rows((2, 0, WIDTH)), no_rows((0, 2, 0))
    )
