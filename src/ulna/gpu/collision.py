"""Keeps a scene on a GPU, tests it for overlap there and searches it for the nearest pair.

All objects are tested one by one, ball against ball first: threads of a warp that each go their own way through a BVH would wait
for each other.
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
from ulna.engine.lanes import WIDTH
from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.kernels.collision.collision_layout import NO_NODE
from ulna.kernels.collision.nearest import nearest_unindexed
from ulna.kernels.collision.overlap import overlaps_unindexed
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.spatial.elementary import all_in_range

_MOST_SCRATCH, _MOST_DISTANCES = 0.25, 1 << 15  # of the free memory; threads that measure distances
_BYTES = 8


class DeviceScene(NamedTuple):
    """A scene on the device.

    Attributes:
        scene: What the drivers take. A table that it lacks is one without rows.
        sizes: The numbers of its joints and bodies, and whether all shapes are boxes.
        number: Over which its tables are: float32 for boxes alone.
    """

    scene: Scene
    sizes: tuple[int, int, bool]
    number: Any


class DeviceScenes:
    """The scenes of a robot and a world on the device. Those of the last world are kept."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last = checker, {}

    def of(self, world: World | None, self_collision: bool, number: Any) -> DeviceScene:
        """The scene of a world."""
        scene, last = self._checker.scene_of(world, self_collision), self._last.get(number)
        if last is None or last[0] is not scene:
            last = self._last[number] = scene, _on_device(scene, number)
        return last[1]


def _on_device(scene: Scene, number: Any) -> DeviceScene:
    """The scene, as one whose objects are all tested one by one."""
    of_boxes, numbers = scene.vertices is None, np.r_[scene.first : scene.end, numbers_below(scene.nodes, scene.root)]
    number = number if of_boxes else np.float64
    solids = table_of(scene.objects, scene.nodes, numbers)
    every = scene._replace(objects=solids, nodes=np.empty((0, WIDTH)), root=NO_NODE, first=0, end=len(solids))
    there = Scene._make(part if isinstance(part, int) else device.on_device(_over(number, part)) for part in every)
    return DeviceScene(there, (len(scene.joints), len(scene.bodies), of_boxes), number)


def _over(number: Any, part: NDArray[Any] | None) -> NDArray[Any]:
    """A table over a number; one of whole numbers or of bools as it is. A launch takes no None: it is a table without rows."""
    if part is None:
        return np.empty((0, 3), number)
    return part.astype(number) if part.dtype == np.float64 else part


def distance_scratch(scene: DeviceScene, n: int) -> list[Any]:
    """Scratch for as many threads as measure n distances, or as there is memory for; boxes need none."""
    threads, shapes = max(1, min(n, _MOST_DISTANCES)), [(1, 1)] * len(SCRATCH)
    if not scene.sizes[-1]:
        threads = max(1, int(min(threads, _MOST_SCRATCH * device.free_memory() / (_BYTES * sum(map(prod, SCRATCH))))))
        shapes = list(SCRATCH)
    return [cuda.device_array((threads, *shape), np.float64) for shape in shapes]


@kernel
def _as_it_is(scene):
    return scene


@kernel
def _of_boxes(scene):
    """The scene without vertices and points: a launch takes no None."""
    joints, bodies, _, pairs, objects, _, nodes, root, first, end, may_touch = scene
    return Scene(joints, bodies, None, pairs, objects, None, nodes, root, first, end, may_touch)


@cache
def overlaps_of(n_joints: int, n_bodies: int, of_boxes: bool):
    """The driver for robots of these sizes: whether each q touches anything, to the bools of out, shape (n,)."""
    of_joints, of_bodies, as_scene = 12 * n_joints, 12 * n_bodies, _of_boxes if of_boxes else _as_it_is

    def overlaps(of_launch, q, out, out_of_range):
        i = cuda.grid(1)
        if i < q.shape[0]:
            if not all_in_range(q[i]):
                out_of_range[0] = 1
            scene = as_scene(of_launch)
            joint_rows, body_rows = cuda.local.array(of_joints, np.float64), cuda.local.array(of_bodies, np.float64)
            place_bodies(scene.joints, scene.bodies, q[i], joint_rows, body_rows)
            out[i] = overlaps_unindexed(scene, body_rows, q[i, 0]) > 0.0

    return overlaps


@cache
def distances_of(n_joints: int, n_bodies: int, of_boxes: bool):
    """The driver for robots of these sizes: the least signed distance of each q to out, shape (n,).

    The scratch of EPA is an array for each thread: points (m, ...), faces (m, ...) and edges (m, ...). So m threads do all.
    """
    of_joints, of_bodies, as_scene = 12 * n_joints, 12 * n_bodies, _of_boxes if of_boxes else _as_it_is

    def distances(of_launch, corners, faces, edges, q, out, out_of_range):
        thread = cuda.grid(1)
        if thread < corners.shape[0]:
            scene = as_scene(of_launch)
            joint_rows, body_rows = cuda.local.array(of_joints, np.float64), cuda.local.array(of_bodies, np.float64)
            scratch = corners[thread], faces[thread], edges[thread]
            for i in range(thread, q.shape[0], corners.shape[0]):
                if not all_in_range(q[i]):
                    out_of_range[0] = 1
                place_bodies(scene.joints, scene.bodies, q[i], joint_rows, body_rows)
                out[i] = nearest_unindexed(scene, body_rows, q[i, 0], scratch)[0]

    return distances
