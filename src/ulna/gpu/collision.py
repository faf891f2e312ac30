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
from ulna.errors import DeviceError
from ulna.gpu import device
from ulna.gpu.staged import over_rows, threads_for
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
        sizes: The numbers of its joint positions, joints and bodies, and whether all shapes are boxes.
        number: Over which its tables are: float32 for boxes alone.
    """

    scene: Scene
    sizes: tuple[int, int, int, bool]
    number: Any


class DeviceScenes:
    """The scenes of a robot and a world on the device. Those of the last world are kept."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last = checker, {}

    def of(self, world: World | None, self_collision: bool, number: Any) -> DeviceScene:
        """The scene of a world."""
        scene, last = self._checker.scene_of(world, self_collision), self._last.get(number)
        if last is None or last[0] is not scene:
            last = self._last[number] = scene, _on_device(scene, self._checker.tree.n_dof, number)
        return last[1]


def _on_device(scene: Scene, n_dof: int, number: Any) -> DeviceScene:
    """The scene, as one whose objects are all tested one by one."""
    of_boxes, numbers = scene.vertices is None, np.r_[scene.first : scene.end, numbers_below(scene.nodes, scene.root)]
    number = number if of_boxes else np.float64
    solids = table_of(scene.objects, scene.nodes, numbers)
    every = scene._replace(objects=solids, nodes=np.empty((0, WIDTH)), root=NO_NODE, first=0, end=len(solids))
    there = Scene._make(part if isinstance(part, int) else device.on_device(_over(number, part)) for part in every)
    return DeviceScene(there, (n_dof, len(scene.joints), len(scene.bodies), of_boxes), number)


def _over(number: Any, part: NDArray[Any] | None) -> NDArray[Any]:
    """A table over a number; one of whole numbers or of bools as it is. A launch takes no None: it is a table without rows."""
    if part is None:
        return np.empty((0, 3), number)
    return part.astype(number) if part.dtype == np.float64 else part


def distance_scratch(scene: DeviceScene, n: int) -> tuple[list[Any], int]:
    """Scratch of threads that measure n distances, and of how many: as many as there is memory for. Boxes need none."""
    if scene.sizes[-1]:
        return [device.empty((1, 1, 1), np.float64) for _ in SCRATCH], device.LAUNCH.at_most
    room, block = _MOST_SCRATCH * device.free_memory() / (_BYTES * sum(map(prod, SCRATCH))), threads_for(scene.sizes[0], 1)
    threads = int(min(n, _MOST_DISTANCES, room))
    if threads < min(n, block):
        needed = min(n, block) * _BYTES * sum(map(prod, SCRATCH)) / _MOST_SCRATCH / 1e9
        raise DeviceError(f"too little memory is free on the device: distances of such shapes need {needed:.2g} GB")
    return [device.empty((threads, *shape), np.float64) for shape in SCRATCH], threads


@kernel
def _as_it_is(scene):
    return scene


@kernel
def _of_boxes(scene):
    """The scene without vertices and points: a launch takes no None."""
    joints, bodies, _, pairs, objects, _, nodes, root, first, end, may_touch = scene
    return Scene(joints, bodies, None, pairs, objects, None, nodes, root, first, end, may_touch)


@cache
def overlaps_of(n_dof: int, n_joints: int, n_bodies: int, of_boxes: bool) -> Any:
    """The driver for robots of these sizes: whether each q touches anything, bools of shape (n, 1), by (scene,)."""
    of_joints, as_scene = 12 * n_joints, _of_boxes if of_boxes else _as_it_is

    @kernel
    def overlaps(tables, q, _place, scratch, out, _marks):
        scene, body_rows = as_scene(tables[0]), scratch[of_joints:]
        place_bodies(scene.joints, scene.bodies, q, scratch[:of_joints], body_rows)
        out[0] = overlaps_unindexed(scene, body_rows, q[0]) > 0.0
        return not all_in_range(q)

    return over_rows(overlaps, n_dof, 1, scratch=of_joints + 12 * n_bodies, dtype=np.bool_)


@cache
def distances_of(n_dof: int, n_joints: int, n_bodies: int, of_boxes: bool) -> Any:
    """The driver for robots of these sizes: the least signed distance of each q, shape (n, 1), by (scene, points, faces, edges).

    The scratch of EPA is an array for each thread: points (m, ...), faces (m, ...) and edges (m, ...). So m threads do all.
    """
    of_joints, as_scene = 12 * n_joints, _of_boxes if of_boxes else _as_it_is

    @kernel
    def distances(tables, q, place, scratch, out, _marks):
        scene, thread, body_rows = as_scene(tables[0]), min(place[2], tables[1].shape[0] - 1), scratch[of_joints:]
        place_bodies(scene.joints, scene.bodies, q, scratch[:of_joints], body_rows)
        polytope = tables[1][thread], tables[2][thread], tables[3][thread]
        out[0] = nearest_unindexed(scene, body_rows, q[0], polytope)[0]
        return not all_in_range(q)

    return over_rows(distances, n_dof, 1, scratch=of_joints + 12 * n_bodies)
