"""Checks the robot at q against itself and against the objects of a world."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions
from ulna.collision.attached import Attached
from ulna.collision.bodies import Bodies, checked_pairs, make_bodies
from ulna.collision.clouds import PointCloud
from ulna.collision.distances import Distances, distances_of
from ulna.collision.edge_report import EdgeReport
from ulna.collision.near_pairs import NearPairs, as_reach, find_near_pairs, reports_of
from ulna.collision.object_tables import NO_OBJECTS
from ulna.collision.objects import Objects
from ulna.collision.own_points import owners_near
from ulna.collision.sampled_pairs import FoundPairs
from ulna.collision.scene_tables import NO_PAIRS, may_touch_of, scene_of
from ulna.collision.world import World
from ulna.description.arrays import as_number
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import Description
from ulna.description.shapes import lengths
from ulna.drivers import contacts, continuous, nearest, overlap
from ulna.engine.bound import bind
from ulna.engine.threads import as_threads, in_parts
from ulna.errors import InputError
from ulna.kernels.collision.collision_layout import (
    BODY,
    CONTACT_WIDTH,
    EDGE_CONTACT,
    EDGE_OUT_OF_RANGE,
    FREE,
    NEAREST,
    NEAREST_WIDTH,
    OUT_OF_RANGE,
    OVERLAPS,
)
from ulna.kernels.collision.scene import Scene
from ulna.kinematics.positions import as_out, as_positions, flat, for_kernel, refuse_out_of_range, rows_of_both
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
LEAST_RESOLUTION = 1e-5  # [m]
WORTH_A_THREAD = 64  # edges
_NOTHING_BOUND = False, None, None, None
_NO_LAST_SCENE: tuple[Any, ...] = None, None, None
_TOUCHES, _NEAREST = 2, 3  # places in Checker.prebound[0]


class Checker:
    """The collision queries of one robot."""

    def __init__(
        self,
        description: Description,
        tree: Tree,
        attached: tuple[Attached, ...],
        given: AllowedCollisions | None,
        found: FoundPairs,
    ) -> None:
        """Of a robot.

        Args:
            description: The robot.
            tree: The same as arrays.
            attached: The objects attached to it.
            given: The pairs of links that may touch, if the user has given them.
            found: Those that are found otherwise, when first needed.
        """
        self.description, self.tree, self.attached, self.given, self.found = description, tree, attached, given, found
        self._last_scene = _NO_LAST_SCENE
        self._may_touch: tuple[tuple[frozenset[str], ...], NDArray[np.bool_]] | None = None
        self.prebound: list[tuple[Any, ...]] = [_NOTHING_BOUND]
        """One tuple, of the last scene (``scene`` of ``engine.bound.Quick``)."""

    @cached_property
    def bodies(self) -> Bodies:
        """The collision bodies of the robot and of the objects attached to it.

        Raises:
            GeometryError: There are no collision shapes, or one of a kind that cannot be checked.
        """
        return make_bodies(self.description, self.tree, self.attached)

    @property
    def allowed(self) -> AllowedCollisions:
        """The pairs of links that may touch: those given, or else those found and those of the SRDF."""
        return self.found.counted(self.bodies) if self.given is None else self.given

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """The pairs of bodies that are checked, shape (n, 2): those not allowed to touch."""
        allowed = self.found.without_counts(self.bodies) if self.given is None else self.given
        return checked_pairs(self.bodies, self.tree, allowed, self.attached)

    def in_collision(
        self,
        q: ArrayLike,
        world: World | None,
        self_collision: bool,
        out: NDArray[np.bool_] | None = None,
        threads: int | None = None,
    ) -> bool | NDArray[np.bool_]:
        """Whether anything touches.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The obstacles, if any.
            self_collision: Whether the robot is also checked against itself.
            out: Where to write the results, shape (...,); a new array unless given.
            threads: How many threads; the default unless given.

        Returns:
            A bool for one q without ``out``, else shape (...,).

        Raises:
            InputError: q has another shape or is out of range, ``out`` does not fit, ``threads`` is not a number of threads, or
                there is nothing to check.
            GeometryError: The robot has no collision shapes, or one of a kind that cannot be checked.
        """
        objects = self._objects(world)
        scene = self._scene(objects, self_collision)
        if out is None and threads is None:
            return self._of_scene(_TOUCHES, objects, self_collision, scene)(q)
        return self._any_touch(scene, q, out, threads)

    def _any_touch(
        self, scene: Scene, q: ArrayLike, out: NDArray[np.bool_] | None = None, threads: int | None = None
    ) -> bool | NDArray[np.bool_]:
        """The same, in Python."""
        q = as_positions(q, self.tree)
        if q.ndim == 1 and threads is not None:
            as_threads(threads)  # refused where it is no number of threads
        if q.ndim == 1 and out is None:
            return self._touches(q, scene)
        hits = as_out(out, q.shape[:-1], q, dtype=np.bool_)
        self._touch_each(q, scene, hits, threads)
        return hits

    def signed_distance(
        self,
        q: ArrayLike,
        world: World | None,
        self_collision: bool,
        out: NDArray[np.float64] | None = None,
        threads: int | None = None,
    ) -> Any:
        """The least signed distance [m]: a number for one q without ``out``, else shape (...,). Arguments as ``in_collision``.

        Raises:
            InputError: As ``in_collision``.
            GeometryError: As ``in_collision``.
        """
        objects = self._objects(world)
        scene = self._scene(objects, self_collision)
        if out is None and threads is None:
            return self._of_scene(_NEAREST, objects, self_collision, scene)(q)
        return self._least_distance(scene, q, out, threads)

    def _least_distance(self, scene: Scene, q: ArrayLike, out: Array | None = None, threads: int | None = None) -> Any:
        """The same, in Python."""
        q = as_positions(q, self.tree)
        if q.ndim == 1 and out is None:
            return float(self._nearest(q, scene, threads)[NEAREST])
        result = as_out(out, q.shape[:-1], q)
        result[...] = self._nearest(q, scene, threads)[..., NEAREST]
        return result

    def distance_gradient(
        self,
        q: ArrayLike,
        world: World | None,
        self_collision: bool,
        out: NDArray[np.float64] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float64]:
        """The gradient of the least signed distance [m/rad or 1], shape (..., n_dof). Arguments as ``in_collision``.

        Raises:
            InputError: As ``in_collision``.
            GeometryError: As ``in_collision``.
        """
        objects = self._objects(world)
        scene = self._scene(objects, self_collision)
        q = as_positions(q, self.tree)
        gradient, rows = as_out(out, q.shape, q), flat(q)
        found = self._nearest(q, scene, threads).reshape(-1, NEAREST_WIDTH)
        self._gradients(rows, scene, found, gradient.reshape(rows.shape), threads)
        return gradient

    def edge_in_collision(
        self,
        q_a: ArrayLike,
        q_b: ArrayLike,
        world: World | None,
        self_collision: bool,
        resolution: float,
        threads: int | None = None,
    ) -> EdgeReport:
        """Whether anything touches on straight lines from q_a to q_b, shape (..., n_dof) each; the rest as ``in_collision``.

        Raises:
            InputError: As ``in_collision``; or ``resolution`` [m] is not a number of at least ``LEAST_RESOLUTION``, or the
                shapes of q_a and q_b cannot be broadcast.
            GeometryError: As ``in_collision``.
        """
        resolution = as_number("resolution", resolution, LEAST_RESOLUTION, f"a length of at least {LEAST_RESOLUTION:g} m")
        objects = self._objects(world)
        scene = self._scene(objects, self_collision)
        starts, ends = as_positions(q_a, self.tree, "q_a"), as_positions(q_b, self.tree, "q_b")
        if starts.ndim == ends.ndim == 1:
            return self._one_edge(starts, ends, scene, float(resolution), threads)
        batch, a, b = rows_of_both(starts, ends, "q_a", "q_b")
        status, free = self._edges(a, b, scene, resolution, threads)
        if (status == EDGE_OUT_OF_RANGE).any():
            refuse_out_of_range(starts, "q_a")
            refuse_out_of_range(ends, "q_b")
        q = (a + free[:, None] * (b - a)).reshape(*batch, self.tree.n_dof)
        return EdgeReport((status == EDGE_CONTACT).reshape(batch), free.reshape(batch), q)

    def _one_edge(self, a: Array, b: Array, scene: Scene, resolution: float, threads: int | None) -> EdgeReport:
        """The report of one edge, shape (n_dof,) each."""
        if threads is not None:
            as_threads(threads)  # refused where it is no number of threads
        status, free = np.empty(1, dtype=np.int64), np.empty(1)
        continuous.edges_each(*scene, for_kernel(a[None]), for_kernel(b[None]), resolution, status, free)
        outcome, free_until = status.item(), free.item()
        if outcome == EDGE_OUT_OF_RANGE:
            refuse_out_of_range(a, "q_a")
            refuse_out_of_range(b, "q_b")
        return EdgeReport(outcome == EDGE_CONTACT, free_until, a + free_until * (b - a))

    def check_collision(
        self, q: ArrayLike, world: World | None, self_collision: bool, max_distance: float, threads: int | None = None
    ) -> Any:
        """The pairs at most ``max_distance`` [m] apart: a report for one q, else an array of reports, shape (...,).

        Raises:
            InputError: As ``in_collision``; or ``max_distance`` is not a number of at least 0.
            GeometryError: As ``in_collision``.
        """
        objects = self._objects(world)  # read once, so that the report has the names of the objects that were checked
        q = as_positions(q, self.tree)
        found = self._near(q, objects, self_collision, as_reach("max_distance", max_distance), threads, gradients=False)
        of_rows = reports_of(found, self.bodies, objects.names)
        if q.ndim == 1:
            return next(of_rows)
        reports = np.empty(q.shape[:-1], dtype=object)
        for i, report in enumerate(of_rows):
            reports.reshape(-1)[i] = report
        return reports

    def distances(
        self, q: ArrayLike, world: World | None, self_collision: bool, within: float, threads: int | None = None
    ) -> Distances:
        """The pairs at most ``within`` [m] apart, as arrays (``Robot.distances``).

        Raises:
            InputError: As ``in_collision``; or ``within`` is not a number of at least 0.
            GeometryError: As ``in_collision``.
        """
        objects, q = self._objects(world), as_positions(q, self.tree)
        found = self._near(q, objects, self_collision, as_reach("within", within), threads, gradients=True)
        return distances_of(found, self.bodies, objects.names)

    def _near(
        self, q: Array, objects: Objects, self_collision: bool, within: float, threads: int | None, *, gradients: bool
    ) -> NearPairs:
        """The pairs near each other at each q of a batch, shape (..., n_dof)."""
        if threads is not None:
            as_threads(threads)  # refused where it is no number of threads, even for one q
        rows = q[None] if q.ndim == 1 else flat(q)
        scene = self._scene(objects, self_collision)
        found = find_near_pairs(rows, scene, len(objects.names), within, gradients=gradients, threads=threads)
        if found is None:
            refuse_out_of_range(q)
            raise AssertionError("an entry of q is out of range")
        return found

    def _of_scene(self, place: int, objects: Objects, self_collision: bool, scene: Scene) -> Callable[[ArrayLike], Any]:
        """A function of q in the last scene, in C if the extension is there; made when it is first needed."""
        of = None if objects is NO_OBJECTS else objects
        last = self.prebound[0]
        if last[0] is not of or last[1] is not self_collision:
            last = of, self_collision, None, None
        function: Any = last[place]
        if function is None:
            function = self._bound(place, scene)
            self.prebound[0] = (*last[:2], function, last[3]) if place == _TOUCHES else (*last[:3], function)
        return function

    def _bound(self, place: int, scene: Scene) -> Callable[[ArrayLike], Any]:
        n = self.tree.n_dof
        if place == _TOUCHES:
            in_python = partial(self._any_touch, scene)
            in_c = bind(overlap.overlap_one, "truth", tuple(scene), n, (FREE, OVERLAPS), in_python)
        else:
            in_python = partial(self._least_distance, scene)
            in_c = bind(nearest.nearest_batch, "number", tuple(scene), n, (NEAREST_WIDTH,), in_python)
        return in_c or in_python

    def __getstate__(self) -> dict[str, Any]:
        """What is kept of the last questions is not copied, nor pickled."""
        return {**self.__dict__, "_last_scene": _NO_LAST_SCENE, "prebound": [_NOTHING_BOUND]}

    def _touch_each(self, q: NDArray[np.float64], scene: Scene, out: NDArray[np.bool_], threads: int | None) -> None:
        """Write to out, shape (...,), whether anything touches."""
        if q.ndim == 1:
            out[()] = self._touches(q, scene)
            return
        rows, of_rows = flat(q), out.reshape(-1)
        if not in_parts(lambda part: overlap.overlap_batch(*scene, rows[part], of_rows[part]), len(rows), threads=threads):
            refuse_out_of_range(q)

    def _gradients(self, rows: Array, scene: Scene, found: Array, out: Array, threads: int | None) -> None:
        """Write the gradient of the nearest pair found for each row of q to out, shape (n, n_dof)."""
        pairs = found[:, BODY:].astype(np.int64)
        all_contacts = np.empty((len(pairs), CONTACT_WIDTH))

        def run(part: slice) -> bool:
            of_q = np.arange(part.stop - part.start)
            return contacts.contacts_each(*scene, for_kernel(rows[part]), of_q, pairs[part], all_contacts[part], out[part])

        if len(rows) == 1:
            run(slice(0, 1))
        else:
            in_parts(run, len(rows), threads=threads)

    def _edges(self, a: Array, b: Array, scene: Scene, resolution: float, threads: int | None) -> tuple[NDArray[np.int64], Array]:
        """The status of each edge, and the fraction of it that is free, shape (n,) each."""
        status, free = np.empty(len(a), dtype=np.int64), np.empty(len(a))

        def run(part: slice) -> bool:
            return continuous.edges_each(*scene, for_kernel(a[part]), for_kernel(b[part]), resolution, status[part], free[part])

        in_parts(run, len(a), least=WORTH_A_THREAD, threads=threads)
        return status, free

    def _touches(self, q: NDArray[np.float64], scene: Scene) -> bool:
        result = overlap.overlap_one(*scene, for_kernel(q))
        if result == OUT_OF_RANGE:
            refuse_out_of_range(q)
        return result == OVERLAPS

    def _nearest(self, q: NDArray[np.float64], scene: Scene, threads: int | None = None) -> NDArray[np.float64]:
        """The nearest pair of each q (``kernels.collision.nearest``), shape (..., NEAREST_WIDTH)."""
        if q.ndim == 1:
            if threads is not None:
                as_threads(threads)  # refused where it is no number of threads
            one = np.empty((1, NEAREST_WIDTH))
            if not nearest.nearest_batch(*scene, q[None], one):
                refuse_out_of_range(q)
            return one[0]
        found, rows = np.empty((*q.shape[:-1], NEAREST_WIDTH)), flat(q)
        out = found.reshape(-1, NEAREST_WIDTH)
        if not in_parts(lambda part: nearest.nearest_batch(*scene, rows[part], out[part]), len(rows), threads=threads):
            refuse_out_of_range(q)
        return found

    def links_that_touch(self, q: ArrayLike) -> tuple[tuple[str, str], ...]:
        """The pairs of links that touch at q, shape (n_dof,), of those that are checked.

        Raises:
            InputError: q is not one configuration.
            GeometryError: As ``in_collision``.
        """
        q = as_positions(q, self.tree, "at")
        if q.ndim != 1:
            raise InputError("at", f"shape {q.shape}; one configuration, shape ({self.tree.n_dof},), is expected")
        held, report = {one.name for one in self.attached}, self.check_collision(q, None, self_collision=True, max_distance=0.0)
        pairs = dict.fromkeys((pair.link_a, str(pair.link_b)) for pair in report.pairs if pair.signed_distance <= 0.0)
        return tuple(pair for pair in pairs if held.isdisjoint(pair))

    def links_near(
        self, cloud: PointCloud, q: ArrayLike, within: float, pose: ArrayLike | None
    ) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """The links and attached objects, and which of them is nearest to each ball of a cloud (``Robot.links_near``).

        Raises:
            InputError: q is not one configuration, ``within`` is not a length, or the pose is not a rigid motion.
            GeometryError: As ``in_collision``.
        """
        if not isinstance(cloud, PointCloud):
            raise InputError("cloud", f"{type(cloud).__name__}; an ulna.PointCloud is expected")
        q = as_positions(q, self.tree)
        if q.ndim != 1:
            raise InputError("q", f"shape {q.shape}; one configuration, shape ({self.tree.n_dof},), is expected")
        refuse_out_of_range(q)
        T = as_one_pose(np.eye(4) if pose is None else pose, "pose")
        return owners_near(cloud, T, q, self.tree.joints, self.bodies, lengths("within", (within,), 1)[0])

    def scene_of(self, world: World | None, self_collision: bool) -> Scene:
        """What is checked, as the kernels take it.

        Raises:
            InputError: There is nothing to check.
            GeometryError: The robot has no collision shapes, or one of a kind that cannot be checked.
        """
        return self._scene(self._objects(world), self_collision)

    def scene_and_names(self, world: World | None) -> tuple[Scene, list[str]]:
        """The robot with itself and a world, as the kernels take it, and the objects' names by their numbers in it.

        Raises:
            GeometryError: As ``scene_of``.
        """
        objects = self._objects(world)
        return self._scene(objects, True), objects.names

    def _objects(self, world: World | None) -> Objects:
        if world is not None and not isinstance(world, World):
            raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
        return NO_OBJECTS if world is None else world.objects()

    def _scene(self, objects: Objects, self_collision: bool) -> Scene:
        """The arguments of the kernels: the robot and the objects. The last ones are kept."""
        last = self._last_scene
        if last[0] is objects and last[1] is self_collision:
            return last[2]
        if objects is NO_OBJECTS and not self_collision:
            raise InputError("world", "is None and self_collision is False, so there is nothing to check")
        known = self._may_touch
        if known is None or known[0] != objects.touch_sets:
            known = self._may_touch = objects.touch_sets, may_touch_of(self.bodies, objects.touch_sets)
        scene = scene_of(self.tree.joints, self.bodies, self.pairs if self_collision else NO_PAIRS, objects, known[1])
        self._last_scene = objects, self_collision, scene
        return scene
