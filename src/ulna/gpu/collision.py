"""Tests a scene for overlap on a GPU, and searches it for the nearest pair.

Every object is tested, bounding spheres first. In a BVH the threads of a warp would diverge and wait for each other.
"""

from functools import cache
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.objects import numbers_below, table_of
from ulna.collision.world import World
from ulna.engine.decorators import kernel
from ulna.engine.lanes import WIDTH, splat
from ulna.errors import DeviceError
from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.gpu.staged import over_rows, threads_for
from ulna.kernels.chain.poses import frame_pose, tree_poses
from ulna.kernels.collision.collision_layout import NO_NODE
from ulna.kernels.collision.nearest import nearest_unindexed
from ulna.kernels.collision.posed_pair import BALLS, body_at, may_touch, object_at, place_bodies, rows_overlap
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.distance.pairs import is_searched
from ulna.kernels.layout import REACH, SHAPE
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import constant_pose
from ulna.kernels.spatial.vectors import dot, minus, origin

_MAX_SCRATCH, _MAX_DISTANCES = 0.25, 1 << 15  # fraction of the free memory; threads that measure distances
_BYTES = 8
# All shapes are boxes; every pair has a closed form of its distance (balls, capsules and boxes); any shapes.
BOXES, CLOSED, ANY = 0, 1, 2
_is_searched: Any = getattr(is_searched, "py_func", is_searched)


class DeviceScene(NamedTuple):
    """A scene on the device.

    Attributes:
        tables: The arguments of the drivers: the scene alone. A missing table has no rows.
        sizes: The numbers of joint positions, joints and bodies, and the kind of its shapes: BOXES, CLOSED or ANY.
        number: The number type of its tables: float32 for boxes alone.
        on_host: The original scene on the host.
    """

    tables: device.Tables
    sizes: tuple[int, int, int, int]
    number: Any
    on_host: Scene


class DeviceScenes:
    """The scenes of a robot and a world on the device; caches the scenes of the last world."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last = checker, {}

    def of(self, world: World | None, self_collision: bool, number: Any) -> DeviceScene:
        """The scene of a world."""
        scene, last = self._checker.scene_of(world, self_collision), self._last.get(number)
        if last is None or last[0] is not scene:
            last = self._last[number] = scene, _on_device(scene, self._checker.tree.n_dof, number)
        return last[1]


def _on_device(scene: Scene, n_dof: int, number: Any) -> DeviceScene:
    """Copy a scene to the device, without its BVH."""
    only_boxes, numbers = scene.vertices is None, np.r_[scene.first : scene.end, numbers_below(scene.nodes, scene.root)]
    number = number if only_boxes else np.float64
    solids = table_of(scene.objects, scene.nodes, numbers)
    every = scene._replace(objects=solids, nodes=np.empty((0, WIDTH)), root=NO_NODE, first=0, end=len(solids))
    there = Scene._make(part if isinstance(part, int) else device.on_device(_over(number, part)) for part in every)
    kind = BOXES if only_boxes else ANY if _any_is_searched(scene, solids) else CLOSED
    return DeviceScene(device.Tables((there,)), (n_dof, len(scene.joints), len(scene.bodies), kind), number, every)


def _any_is_searched(scene: Scene, solids: NDArray[Any]) -> bool:
    """Whether any pair's distance has no closed form."""
    own, others = (np.unique(table[:, SHAPE]).astype(int).tolist() for table in (scene.bodies, solids))
    return any(_is_searched(min(a, b), max(a, b)) for a in own for b in (*own, *others))


def _over(number: Any, part: NDArray[Any] | None) -> NDArray[Any]:
    """Convert a float64 table to a number type; None, which a launch refuses, becomes an empty table."""
    if part is None:
        return np.empty((0, 3), number)
    return part.astype(number) if part.dtype == np.float64 else part


def distance_scratch(scene: DeviceScene, n: int) -> tuple[list[Any], int]:
    """Scratch for n distances, and the number of threads that memory allows. Closed forms need no scratch."""
    if scene.sizes[-1] != ANY:
        return [], device.LAUNCH.at_most
    room, block = _MAX_SCRATCH * device.free_memory() / (_BYTES * sum(map(prod, SCRATCH))), threads_for(scene.sizes[0], 1)
    threads = int(min(n, _MAX_DISTANCES, room))
    if threads < min(n, block):
        needed = min(n, block) * _BYTES * sum(map(prod, SCRATCH)) / _MAX_SCRATCH / 1e9
        raise DeviceError(f"too little memory is free on the device: distances of such shapes need {needed:.2g} GB")
    return [cuda.device_array((threads, *shape), np.float64) for shape in SCRATCH], threads


@kernel
def as_it_is(scene):
    """The scene of a launch."""
    return scene


@kernel
def of_boxes(scene):
    """The scene of a launch without vertices and points, since a launch accepts no None."""
    joints, bodies, _, pairs, objects, _, nodes, root, first, end, may_touch = scene
    return Scene(joints, bodies, None, pairs, objects, None, nodes, root, first, end, may_touch)


@cache
def overlaps_of(n_dof: int, n_joints: int, n_bodies: int, kind: int) -> Any:
    """The driver for robots of these sizes: whether each q is in collision, bools of shape (n, 1), by (scene,)."""
    of_joints, as_scene = 12 * n_joints, of_boxes if kind == BOXES else as_it_is

    @kernel
    def overlaps(tables, q, _place, scratch, out, _marks):
        scene, center_rows = as_scene(tables[0]), scratch[of_joints:]
        place_centers(scene, q, scratch[:of_joints], center_rows)
        out[0] = any_overlaps(scene, scratch[:of_joints], center_rows, q[0])
        return not all_in_range(q)

    return over_rows(overlaps, n_dof, 1, scratch=of_joints + 3 * n_bodies, dtype=np.bool_)


@kernel
def place_centers(scene, q, joint_rows, center_rows):
    """Write the poses of the joints, and the origins of the bodies, three rows each.

    A thread's rows are in local memory, which all threads together would fill beyond the caches. Bounding spheres separate most
    pairs, and need the origin only; for the others the body's pose is computed again.
    """
    tree_poses(scene.joints, q, joint_rows)
    for k in range(scene.bodies.shape[0]):
        p = origin(frame_pose(scene.bodies, k, joint_rows, q[0]))
        center_rows[3 * k], center_rows[3 * k + 1], center_rows[3 * k + 2] = p


@kernel
def any_overlaps(scene, joint_rows, center_rows, like):
    """Whether any body overlaps an object, or another body of the pairs."""
    bodies, objects = scene.bodies, scene.objects
    for k in range(bodies.shape[0]):
        p, reach_k = (center_rows[3 * k], center_rows[3 * k + 1], center_rows[3 * k + 2]), bodies[k, REACH]
        for w in range(scene.first, scene.end):
            d, reach = minus(p, (objects[w, 3], objects[w, 7], objects[w, 11])), BALLS * (reach_k + objects[w, REACH])
            if dot(d, d) <= reach * reach and not may_touch(scene, k, w):
                ours = body_at(scene, k, frame_pose(bodies, k, joint_rows, like))
                if rows_overlap(ours, object_at(scene, w, constant_pose(objects, w, like)), splat(1.0, like)):
                    return True
    for m in range(scene.pairs.shape[0]):
        k, j = scene.pairs[m, 0], scene.pairs[m, 1]
        p, q = 3 * k, 3 * j
        d = center_rows[p] - center_rows[q], center_rows[p + 1] - center_rows[q + 1], center_rows[p + 2] - center_rows[q + 2]
        reach = BALLS * (bodies[k, REACH] + bodies[j, REACH])
        if dot(d, d) <= reach * reach:
            ours = body_at(scene, k, frame_pose(bodies, k, joint_rows, like))
            if rows_overlap(ours, body_at(scene, j, frame_pose(bodies, j, joint_rows, like)), splat(1.0, like)):
                return True
    return False


@cache
def distances_of(n_dof: int, n_joints: int, n_bodies: int, kind: int) -> Any:
    """The driver for robots of these sizes: the minimum signed distance of each q, shape (n, 1).

    Its tables are (scene,); for ANY shapes (scene, points, faces, edges) with the scratch of EPA, one array per thread. So the
    number of threads is at most the number of these arrays.
    """
    of_joints, as_scene = 12 * n_joints, of_boxes if kind == BOXES else as_it_is
    nearest = _nearest if kind == ANY else _nearest_closed

    @kernel
    def distances(tables, q, place, scratch, out, _marks):
        scene, body_rows = as_scene(tables[0]), scratch[of_joints:]
        place_bodies(scene.joints, scene.bodies, q, scratch[:of_joints], body_rows)
        out[0] = nearest(scene, body_rows, q[0], tables, place[2])
        return not all_in_range(q)

    return over_rows(distances, n_dof, 1, scratch=of_joints + 12 * n_bodies)


@kernel
def _nearest(scene, body_rows, like, tables, thread):
    return nearest_unindexed(scene, body_rows, like, (tables[1][thread], tables[2][thread], tables[3][thread]))[0]


@kernel
def _nearest_closed(scene, body_rows, like, _tables, _thread):
    return nearest_unindexed(scene, body_rows, like, None)[0]
