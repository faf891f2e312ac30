"""Keeps the scenes of a robot and a world on a GPU.

A scene of few solids is one table there, whose solids the drivers test one by one. A scene of many solids, such as a cloud, keeps
the CPU's BVH. Rows and nodes of an arena never change once they are written, so a change of the world copies only what it added.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.objects import few_numbers_below, table_of
from ulna.collision.world import World
from ulna.engine.lanes import WIDTH
from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.kernels.collision.collision_layout import NO_NODE
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.pairs import is_searched
from ulna.kernels.layout import SHAPE

MAX_ONE_BY_ONE = 1024  # solids of a BVH up to which testing all of them is as fast: threads do not diverge
# All shapes are boxes; every pair has a closed form of its distance (balls, capsules and boxes); any shapes.
BOXES, CLOSED, ANY = 0, 1, 2
_is_searched: Any = getattr(is_searched, "py_func", is_searched)
_OF_ROBOT, _OF_ARENA = ("joints", "bodies", "vertices", "pairs", "may_touch"), ("objects", "points", "nodes")


class DeviceScene(NamedTuple):
    """A scene on the device.

    Attributes:
        tables: The arguments of the drivers: the scene alone. A missing table has no rows.
        sizes: The numbers of joint positions, joints and bodies; the kind of its shapes: BOXES, CLOSED or ANY; and whether it has
            a BVH.
        number: The number type of its tables: float32 for boxes without a BVH alone.
        on_host: The scene on the host; without a BVH if it has none on the device.
    """

    tables: device.Tables
    sizes: tuple[int, int, int, int, bool]
    number: Any
    on_host: Scene


class DeviceScenes:
    """The scenes of a robot and a world on the device; caches the scenes of the last world."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last, self._arena = checker, {}, ArenaCopy()
        self._kept: dict[tuple[str, Any], tuple[Any, Any]] = {}  # the robot's tables: the original, and its copy

    def of(self, world: World | None, self_collision: bool, number: Any) -> DeviceScene:
        """The scene of a world."""
        scene, last = self._checker.scene_of(world, self_collision), self._last.get(number)
        if last is None or last[0] is not scene:
            last = self._last[number] = scene, self._on_device(scene, number)
        return last[1]

    def _on_device(self, scene: Scene, number: Any) -> DeviceScene:
        only_boxes, numbers = scene.vertices is None, few_numbers_below(scene.nodes, scene.root, MAX_ONE_BY_ONE)
        if numbers is None:
            number = np.float64  # float32 has too few digits for the places of nodes
            of_world, shapes = self._arena.of(scene)
        else:
            number = number if only_boxes else np.float64
            solids = table_of(scene.objects, scene.nodes, np.r_[scene.first : scene.end, numbers])
            nodes, shapes = np.empty((0, WIDTH)), np.unique(solids[:, SHAPE])
            scene = scene._replace(objects=solids, nodes=nodes, root=NO_NODE, first=0, end=len(solids))
            of_world = {name: device.on_device(_over(number, getattr(scene, name))) for name in _OF_ARENA}
        kind = BOXES if only_boxes else ANY if _any_is_searched(scene, shapes) else CLOSED
        of_robot = {name: self._of_robot(name, getattr(scene, name), number) for name in _OF_ROBOT}
        sizes = self._checker.tree.n_dof, len(scene.joints), len(scene.bodies), kind, numbers is None
        return DeviceScene(device.Tables((scene._replace(**of_robot, **of_world),)), sizes, number, scene)

    def _of_robot(self, name: str, part: NDArray[Any] | None, number: Any) -> Any:
        """A table that belongs to the robot, on the device; copied again only if it is another one."""
        known = self._kept.get((name, number))
        if known is None or known[0] is not part:
            known = self._kept[name, number] = part, device.on_device(_over(number, part))
        return known[1]


class ArenaCopy:
    """The arena of a world on the device (``collision.arena``). An update copies what was appended since the last one."""

    def __init__(self) -> None:
        self._copies: dict[str, tuple[Any, Any, int]] = {}  # the array of the arena, its copy, and the number of rows copied
        self._shapes: set[float] = set()

    def of(self, scene: Scene) -> tuple[dict[str, Any], set[float]]:
        """The arrays of a scene that belong to its arena, on the device; and all shapes of solids that it has had."""
        parts, first = {name: getattr(scene, name) for name in _OF_ARENA}, 0
        for name, part in parts.items():
            if part is None:
                parts[name] = device.on_device(_over(np.float64, None))
                continue
            end = scene.end if name == "objects" else len(part)
            parts[name], first = self._copied(name, part, end)
            if name == "objects":
                self._shapes = (self._shapes if first else set()) | set(np.unique(part[first:end, SHAPE]).tolist())
        cuda.default_stream().synchronize()  # a launch on any other stream finds the copies complete
        return parts, self._shapes

    def _copied(self, name: str, part: NDArray[Any], end: int) -> tuple[Any, int]:
        """The copy of an array up to a row, and the first row that was copied now."""
        source = part if part.base is None else part.base
        known, there, first = self._copies.get(name, (None, None, 0))
        if known is not source:  # cuda.device_array: its memory is freed only after all streams have read it
            there, first = cuda.device_array((max(1, source.size // part.shape[1]), part.shape[1]), part.dtype), 0
        if first < end:
            there[first:end].copy_to_device(part[first:end])
        self._copies[name] = source, there, max(first, end)
        return there, first


def _any_is_searched(scene: Scene, shapes: Any) -> bool:
    """Whether any pair's distance has no closed form, among solids of these shapes."""
    own, others = np.unique(scene.bodies[:, SHAPE]).astype(int).tolist(), map(int, shapes)
    every = *own, *others
    return any(_is_searched(min(a, b), max(a, b)) for a in own for b in every)


def _over(number: Any, part: NDArray[Any] | None) -> NDArray[Any]:
    """Convert a float64 table to a number type; None, which a launch refuses, becomes an empty table."""
    if part is None:
        return np.empty((0, 3), number)
    return part.astype(number) if part.dtype == np.float64 else part
