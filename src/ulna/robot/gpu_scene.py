"""Keeps on a GPU what is checked for collisions. Used by ``robot.gpu_robot``."""

from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.engine import gpu
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH

_MOST_SCRATCH, _MOST_DISTANCES = 0.25, 1 << 15  # of the free memory; threads that measure distances
_BYTES = 8


class DeviceScene(NamedTuple):
    """A scene on the device.

    Attributes:
        parts: The arguments of the drivers.
        sizes: The numbers of its joints and bodies.
        of_boxes: Whether all shapes are boxes.
        number: Over which its tables are: float32 for boxes alone.
    """

    parts: tuple
    sizes: tuple[int, int]
    of_boxes: bool
    number: Any


class DeviceScenes:
    """The scenes of a robot and a world on the device. Those of the last world are kept."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last = checker, {}

    def of(self, world: World | None, self_collision: bool, number: Any) -> DeviceScene:
        """The scene of a world.

        Raises:
            InputError: There is nothing to check.
            GeometryError: The robot has no collision shapes, or one of a kind that cannot be checked.
        """
        scene, last = self._checker.scene_of(world, self_collision), self._last.get(number)
        if last is None or last[0] is not scene:
            last = self._last[number] = scene, _on_device(scene, number)
        return last[1]


def _on_device(scene: Scene, number: Any) -> DeviceScene:
    """The scene, as one whose objects are all tested one by one."""
    of_boxes = scene.vertices is None
    number, every = number if of_boxes else np.float64, scene._replace(n_unindexed=len(scene.objects))
    parts = tuple(gpu.on_device(_over(number, part)) if isinstance(part, np.ndarray) else part for part in every)
    return DeviceScene(parts, (len(scene.joints), len(scene.bodies)), of_boxes, number)


def _over(number: Any, part: NDArray[Any]) -> NDArray[Any]:
    """A table over a number; one of whole numbers or of bools as it is."""
    with np.errstate(over="ignore"):  # an empty child of the BVH has a box at 1e300
        return part.astype(number) if part.dtype == np.float64 else part


def distance_scratch(scene: DeviceScene, n: int) -> list[Any]:
    """Scratch for as many threads as measure n distances, or as there is memory for; boxes need none."""
    threads, shapes = max(1, min(n, _MOST_DISTANCES)), [(1, 1)] * len(SCRATCH)
    if not scene.of_boxes:
        threads = max(1, int(min(threads, _MOST_SCRATCH * gpu.free_memory() / (_BYTES * sum(map(prod, SCRATCH))))))
        shapes = list(SCRATCH)
    return [gpu.cuda.device_array((threads, *shape), np.float64) for shape in shapes]
