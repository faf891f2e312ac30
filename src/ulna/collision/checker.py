"""Checks the robot at q against itself and against the objects of a world: the interface of this folder.

1. ``bodies`` makes a table of the shapes of the robot and its attached objects, and the pairs of them to check. ``objects``
   makes a table of a world's objects with a BVH over them, and lists the links that may touch each object.
2. Both make a *scene*, to which the entries are bound (``bound_scene``). ``overlap`` tests for any contact, ``contacts`` lists
   the contacts, ``nearest`` finds the nearest pair, ``continuous`` checks a whole edge. Scenes of boxes alone have machine code
   of their own.
3. The scene of the last call is cached, with the queries bound to it (``Queries``).
4. Contacts and distances come back as row numbers; ``report`` and ``distances`` look up their names.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions
from ulna.collision.attached import Attached
from ulna.collision.bodies import NO_PAIRS, Bodies, checked_pairs, make_bodies, scene_of, touch_table
from ulna.collision.bound_scene import BoundScene
from ulna.collision.clouds import PointCloud
from ulna.collision.distances import Distances, distances_of
from ulna.collision.entries import contacts, continuous, nearest, overlap
from ulna.collision.near_pairs import as_reach, find_near_pairs, reports_of
from ulna.collision.object_tables import NO_OBJECTS, make_objects
from ulna.collision.object_tree import compact_order
from ulna.collision.objects import Layout, Objects
from ulna.collision.report import EdgeReport
from ulna.collision.sampled_pairs import SampledPairs
from ulna.collision.world import World
from ulna.description.arrays import as_number, as_switch
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import Description
from ulna.description.shapes import lengths
from ulna.engine.bound import Way, bind
from ulna.engine.records import Records
from ulna.engine.threads import MIN_ROWS, in_parts
from ulna.errors import InputError
from ulna.kernels.collision.collision_layout import (
    CONTACT_WIDTH,
    EDGE_CONTACT,
    EDGE_FREE,
    EDGE_OUT_OF_RANGE,
    FIRST_BALL,
    FREE,
    OUT_OF_RANGE,
    OVERLAPS,
    PAIR_BODY,
    PAIR_OTHER,
)
from ulna.kernels.collision.scene import NearestPair, Scene
from ulna.kinematics.positions import (
    as_configuration,
    as_out,
    as_positions,
    flat,
    for_kernel,
    refuse_out_of_range,
    rows_of_both,
)
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
MIN_RESOLUTION = 1e-5  # [m]
WORTH_A_THREAD = 64  # edges
RESOLUTION = 1e-4  # [m], unless another is given
_A_RESOLUTION = f"a length of at least {MIN_RESOLUTION:g} m"
_MAX_POINTS = 1 << 18  # points of a cloud that one call of an entry compares with the robot


class Checker:
    """The collision queries of one robot. Their arguments, results and errors are documented at the methods of ``Robot``."""

    def __init__(
        self,
        description: Description,
        tree: Tree,
        attached: tuple[Attached, ...],
        user_pairs: AllowedCollisions | None,
        sampled_pairs: SampledPairs,
    ) -> None:
        """Take a robot.

        Args:
            description: The robot.
            tree: The same as arrays.
            attached: The objects attached to it.
            user_pairs: The pairs of links that may touch, if the user has given them.
            sampled_pairs: Finds the allowed pairs at their first use, if the user has given none.
        """
        self.description, self.tree, self.attached = description, tree, attached
        self.user_pairs, self.sampled_pairs = user_pairs, sampled_pairs
        self._last: Queries | None = None  # of the last scene
        self._may_touch: tuple[tuple[frozenset[str], ...], NDArray[np.bool_]] | None = None

    @cached_property
    def bodies(self) -> Bodies:
        """The collision bodies of the robot and of the objects attached to it."""
        return make_bodies(self.description, self.tree, self.attached)

    @property
    def allowed(self) -> AllowedCollisions:
        """The pairs of links that may touch: the user's pairs, or else the sampled pairs with those of the SRDF."""
        return self.sampled_pairs.with_counts(self.bodies) if self.user_pairs is None else self.user_pairs

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """The pairs of bodies that are checked, shape (n, 2): all pairs but the allowed ones."""
        allowed = self.sampled_pairs.without_counts(self.bodies) if self.user_pairs is None else self.user_pairs
        return checked_pairs(self.bodies, self.tree, allowed, self.attached)

    def in_collision(
        self, q: ArrayLike, world: World | None, self_collision: bool, out: NDArray[np.bool_] | None = None
    ) -> bool | NDArray[np.bool_]:
        """Whether anything touches: a bool for one q without ``out``, else shape (...,)."""
        objects = _objects_of(world)
        queries = self._queries(objects, self_collision)
        if out is None:
            return queries.overlaps(q, objects.first, objects.end)
        return self.in_collision_by_entries(queries.scene(objects.first, objects.end), q, out)

    def in_collision_by_entries(
        self, scene: BoundScene, q: ArrayLike, out: NDArray[np.bool_] | None = None
    ) -> bool | NDArray[np.bool_]:
        """``in_collision`` in Python."""
        q = as_positions(q, self.tree)
        if q.ndim == 1 and out is None:
            return self._touches(q, scene)
        hits = as_out(out, q.shape[:-1], q, dtype=np.bool_)
        if q.ndim == 1:
            hits[()] = self._touches(q, scene)
        else:
            run, rows, of_rows = scene.bound(overlap.overlap_batch), flat(q), hits.reshape(-1)
            if not in_parts(lambda part: run(rows[part], of_rows[part]), len(rows)):
                refuse_out_of_range(q)
        return hits

    def _touches(self, q: Array, scene: BoundScene) -> bool:
        result = scene.bound(overlap.overlap_one)(for_kernel(q))
        if result == OUT_OF_RANGE:
            refuse_out_of_range(q)
        return result == OVERLAPS

    def signed_distance(self, q: ArrayLike, world: World | None, self_collision: bool, out: Array | None = None) -> Any:
        """The minimum signed distance [m]: a number for one q without ``out``, else shape (...,)."""
        objects = _objects_of(world)
        queries = self._queries(objects, self_collision)
        if out is None:
            return queries.min_distance(q, objects.first, objects.end)
        return self.min_distance(queries.scene(objects.first, objects.end), q, out)

    def min_distance(self, scene: BoundScene, q: ArrayLike, out: Array | None = None) -> Any:
        """``signed_distance`` in Python."""
        q = as_positions(q, self.tree)
        if q.ndim == 1 and out is None:
            return self._nearest(q, scene)["distance"].item()
        result = as_out(out, q.shape[:-1], q)
        result.reshape(-1)[:] = self._nearest(q, scene)["distance"]
        return result

    def _nearest(self, q: Array, scene: BoundScene) -> Records[NearestPair]:
        """The nearest pair at each row of q, shape (n,)."""
        rows = flat(q)
        found = NearestPair.records(len(rows))
        if not _in_parts(scene.bound(nearest.nearest_batch), (rows, found)):
            refuse_out_of_range(q)
        return found

    def distance_gradient(self, q: ArrayLike, world: World | None, self_collision: bool, out: Array | None = None) -> Array:
        """The gradient of the minimum signed distance [m/rad or 1], shape (..., n_dof)."""
        scene, q = self._scene(_objects_of(world), self_collision), as_positions(q, self.tree)
        gradient, rows = as_out(out, q.shape, q), flat(q)
        found = self._nearest(q, scene)
        pairs = np.stack((found["body"], found["other"]), axis=1)
        arrays = for_kernel(rows), pairs, np.empty((len(pairs), CONTACT_WIDTH)), flat(gradient)
        run = scene.bound(contacts.contacts_each)
        _in_parts(lambda q, *rest: run(q, np.arange(len(q)), *rest), arrays)
        return gradient

    def edge_in_collision(
        self, q_a: ArrayLike, q_b: ArrayLike, world: World | None, self_collision: bool, resolution: float
    ) -> EdgeReport:
        """Whether anything touches on straight lines from q_a to q_b, shape (..., n_dof) each."""
        if resolution is not RESOLUTION:
            resolution = as_number("resolution", resolution, MIN_RESOLUTION, _A_RESOLUTION)
        objects = _objects_of(world)
        report = self._queries(objects, self_collision).edge(q_a, q_b, resolution, objects.first, objects.end)
        return report if type(report) is EdgeReport else EdgeReport(*report)

    def edges(self, scene: BoundScene, q_a: ArrayLike, q_b: ArrayLike, resolution: float) -> EdgeReport:
        """``edge_in_collision`` in Python."""
        starts, ends = as_positions(q_a, self.tree, "q_a"), as_positions(q_b, self.tree, "q_b")
        one = starts.ndim == ends.ndim == 1
        batch, a, b = ((), starts[None], ends[None]) if one else rows_of_both(starts, ends, "q_a", "q_b")
        status, free = np.empty(len(a), dtype=np.int64), np.empty(len(a))
        arrays = for_kernel(a), for_kernel(b), status, free
        run = scene.bound(continuous.edges_each)
        _in_parts(lambda a, b, *out: run(a, b, resolution, *out), arrays, WORTH_A_THREAD)
        outcome = status.item() if one else EDGE_OUT_OF_RANGE if (status == EDGE_OUT_OF_RANGE).any() else None
        if outcome == EDGE_OUT_OF_RANGE:
            refuse_out_of_range(starts, "q_a")
            refuse_out_of_range(ends, "q_b")
        if one:
            free_until = free.item()
            return EdgeReport(outcome == EDGE_CONTACT, free_until, starts + free_until * (ends - starts))
        q = (a + free[:, None] * (b - a)).reshape(*batch, self.tree.n_dof)
        return EdgeReport((status == EDGE_CONTACT).reshape(batch), free.reshape(batch), q)

    def check_collision(self, q: ArrayLike, world: World | None, self_collision: bool, max_distance: float) -> Any:
        """The pairs at most ``max_distance`` [m] apart: a report for one q, else an array of reports, shape (...,)."""
        objects = _objects_of(world)  # read once, so that the report names the objects that were checked
        q, within = as_positions(q, self.tree), as_reach("max_distance", max_distance)
        found = find_near_pairs(q, self._scene(objects, self_collision), len(objects.layout.names), within)
        of_rows = reports_of(found, self.bodies, objects)
        if q.ndim == 1:
            return next(of_rows)
        reports = np.empty(q.shape[:-1], dtype=object)
        for i, report in enumerate(of_rows):
            reports.reshape(-1)[i] = report
        return reports

    def distances(self, q: ArrayLike, world: World | None, self_collision: bool, within: float) -> Distances:
        """The pairs at most ``within`` [m] apart, as arrays."""
        objects, q, within = _objects_of(world), as_positions(q, self.tree), as_reach("within", within)
        scene = self._scene(objects, self_collision)
        found = find_near_pairs(q, scene, len(objects.layout.names), within, gradients=True)
        return distances_of(found, self.bodies, objects.layout.names)

    def links_that_touch(self, q: ArrayLike) -> tuple[tuple[str, str], ...]:
        """The checked pairs of links that touch at ``at`` = q, shape (n_dof,)."""
        q = as_configuration(q, self.tree, "at")
        attached, report = (
            {one.name for one in self.attached},
            self.check_collision(q, None, self_collision=True, max_distance=0.0),
        )
        pairs = dict.fromkeys((pair.link_a, str(pair.link_b)) for pair in report.pairs if pair.signed_distance <= 0.0)
        return tuple(pair for pair in pairs if attached.isdisjoint(pair))

    def links_near(
        self, cloud: PointCloud, q: ArrayLike, within: float, pose: ArrayLike | None
    ) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """The names of the links and attached objects, and the index of the nearest for each ball of a cloud.

        The index is -1 where no body is within the distance.
        """
        if not isinstance(cloud, PointCloud):
            raise InputError("cloud", f"{type(cloud).__name__}; an ulna.PointCloud is expected")
        q, names = as_configuration(q, self.tree, "q"), tuple(dict.fromkeys(self.bodies.owners))
        T, within = as_one_pose(np.eye(4) if pose is None else pose, "pose"), lengths("within", (within,), 1)[0]
        owner_of_body = np.array([names.index(owner) for owner in self.bodies.owners])
        owner_of_ball = np.full(len(cloud.points), -1)
        for start in range(0, len(cloud.points), _MAX_POINTS):  # Ctrl-C is noticed between two parts
            part = PointCloud(cloud.points[start : start + _MAX_POINTS], cloud.radius)
            objects = make_objects({"cloud": part}, {"cloud": T}, {})
            found = find_near_pairs(q, BoundScene(scene_of(self.tree.joints, self.bodies, NO_PAIRS, objects)), 0, within)
            pairs = found.pairs[::-1]  # a point's nearest body is written last
            # The part is the only object, so its balls are numbered from 0, in the order of its tree.
            place = pairs[:, PAIR_OTHER] - len(self.bodies.names) - FIRST_BALL
            owner_of_ball[start + compact_order(part.points)[place]] = owner_of_body[pairs[:, PAIR_BODY]]
        return names, owner_of_ball

    def __getstate__(self) -> dict[str, Any]:
        """The state without the cached scene, for copies and pickles."""
        return {**self.__dict__, "_last": None}

    def scene_of(self, world: World | None, self_collision: bool) -> Scene:
        """The robot with a world, as a scene for the kernels."""
        return self.scene_among(_objects_of(world), self_collision)

    def scene_among(self, objects: Objects, self_collision: bool) -> Scene:
        """The robot with objects, as a scene for the kernels."""
        return self._scene(objects, self_collision).scene

    def scene_and_objects(self, world: World | None) -> tuple[BoundScene, Objects]:
        """The robot with itself and a world, bound to the entries; and the world's objects."""
        objects = _objects_of(world)
        return self._scene(objects, True), objects

    def _scene(self, objects: Objects, self_collision: bool) -> BoundScene:
        """The robot and the objects, bound to the entries."""
        return self._queries(objects, self_collision).scene(objects.first, objects.end)

    def _queries(self, objects: Objects, self_collision: bool) -> "Queries":
        """The queries for objects of this layout. The last ones are cached."""
        last = self._last
        if last is not None and last.layout is objects.layout and last.self_collision is self_collision:
            return last
        as_switch("self_collision", self_collision)
        if objects is NO_OBJECTS and not self_collision:
            raise InputError("world", "is None and self_collision is False, so there is nothing to check")
        known = self._may_touch
        if known is None or known[0] != objects.layout.touch_sets:
            known = self._may_touch = objects.layout.touch_sets, touch_table(self.bodies, objects.layout.touch_sets)
        pairs = self.pairs if self_collision else NO_PAIRS
        scene = BoundScene(scene_of(self.tree.joints, self.bodies, pairs, objects, known[1]))
        self._last = last = Queries(self, objects.layout, self_collision, scene)
        return last


class Queries:
    """The queries at one q among objects of one layout, each bound to the layout's tables at its first use.

    A query takes q, and ``first`` and ``end``: the rows of the unindexed objects are those from ``first`` to before ``end``.
    Objects that move are written to new rows.

    Attributes:
        layout: The tables of the objects.
        self_collision: Whether the robot is also checked against itself.
    """

    def __init__(self, checker: Checker, layout: Layout, self_collision: bool, scene: BoundScene) -> None:
        """Take the robot's checker, for calls in Python, and a scene with objects of the layout."""
        self.layout, self.self_collision, self._checker, self._last = layout, self_collision, checker, scene

    def scene(self, first: int, end: int) -> BoundScene:
        """The scene whose unindexed objects have these rows; the last one is cached."""
        self._last = scene = self._last.with_rows(first, end)
        return scene

    @cached_property
    def overlaps(self) -> Callable[[ArrayLike, int, int], Any]:
        """Whether anything touches at q."""
        return self._bound(overlap.overlap_one, "truth", (FREE, OVERLAPS), self._overlaps_in_python)

    @cached_property
    def min_distance(self) -> Callable[[ArrayLike, int, int], Any]:
        """The minimum signed distance at q [m]."""
        return self._bound(nearest.nearest_batch, "number", (), self._distance_in_python, NearestPair.records())

    @cached_property
    def edge(self) -> Callable[[ArrayLike, ArrayLike, float, int, int], Any]:
        """An edge report from q_a to q_b to a resolution [m], or its three values."""
        return self._bound(continuous.edges_each, "edge", (EDGE_FREE, EDGE_CONTACT), self._edge_in_python)

    def _bound(self, entry: Any, kind: Way, codes: tuple[int, ...], fallback: Callable[..., Any], example: Any = None) -> Any:
        return bind(entry, kind, (self._last.scene,), self._checker.tree.n_dof, codes, fallback, example)

    def _overlaps_in_python(self, q: ArrayLike, first: int, end: int) -> bool | NDArray[np.bool_]:
        return self._checker.in_collision_by_entries(self.scene(first, end), q)

    def _distance_in_python(self, q: ArrayLike, first: int, end: int) -> Any:
        return self._checker.min_distance(self.scene(first, end), q)

    def _edge_in_python(self, q_a: ArrayLike, q_b: ArrayLike, resolution: float, first: int, end: int) -> EdgeReport:
        return self._checker.edges(self.scene(first, end), q_a, q_b, resolution)


def _objects_of(world: World | None) -> Objects:
    if world is not None and not isinstance(world, World):
        raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
    return NO_OBJECTS if world is None else world.objects()


def _in_parts(run: Callable[..., bool], arrays: tuple[Any, ...], min_rows: int = MIN_ROWS) -> bool:
    """Run a function of rows of these arrays with ``in_parts``; a single row directly, which takes less time."""
    n = len(arrays[0])
    if n == 1:
        return run(*arrays)
    return in_parts(lambda part: run(*(array[part] for array in arrays)), n, min_rows)
