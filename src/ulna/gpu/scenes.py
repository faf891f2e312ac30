"""Keeps the scenes of a robot and a world on a GPU.

A scene of few solids is one table there, whose solids the drivers test one by one. A scene of many solids has a BVH: that of the
CPU, and those of large clouds, which are built on the device. Rows and nodes of an arena never change once they are written, so a
change of the world copies only what it added.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.clouds import PointCloud
from ulna.collision.object_tables import NO_OBJECTS, ObjectTables
from ulna.collision.objects import Objects, few_numbers_below, table_of
from ulna.collision.world import World, WorldState, refuse_no_world
from ulna.engine.lanes import WIDTH
from ulna.gpu import device
from ulna.gpu.cloud_trees import MAX_CLOUDS, CloudTrees, PlacedCloud
from ulna.gpu.device import cuda
from ulna.gpu.device_array import order
from ulna.kernels.collision.collision_layout import NO_NODE, NODE_ROWS
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.pairs import is_searched
from ulna.kernels.layout import SHAPE

MAX_ONE_BY_ONE = 1024  # solids of a BVH up to which testing all of them is as fast: threads do not diverge
# All shapes are boxes; every pair has a closed form of its distance (balls, capsules and boxes); any shapes.
BOXES, CLOSED, ANY = 0, 1, 2
_ANYWHERE = np.eye(4)  # the pose of a cloud without points
_is_searched: Any = getattr(is_searched, "py_func", is_searched)
_OF_ROBOT, _OF_ARENA = ("joints", "bodies", "vertices", "pairs", "may_touch"), ("objects", "points", "nodes")


class DeviceScene(NamedTuple):
    """A scene on the device.

    Attributes:
        tables: The arguments of the drivers: the scene alone. A missing table has no rows.
        sizes: The numbers of joint positions, joints and bodies; the kind of its shapes: BOXES, CLOSED or ANY; and whether it has
            a BVH.
        number: The number type of its tables: float32 for boxes without a BVH alone.
        on_host: The scene on the host: without the clouds, and without a BVH if it has none on the device.
        clouds: The clouds whose BVHs were built on the device.
    """

    tables: device.Tables
    sizes: tuple[int, int, int, int, bool]
    number: Any
    on_host: Scene
    clouds: tuple[PlacedCloud, ...]


class DeviceScenes:
    """The scenes of a robot and a world on the device; caches the scenes of the last world."""

    def __init__(self, checker: Checker) -> None:
        self._checker, self._last, self._parts, self._arena = checker, {}, WorldParts(), ArenaCopy()
        self._kept: dict[tuple[str, Any], tuple[Any, Any]] = {}  # the robot's tables: the original, and its copy
        self._stream: Any = 0  # of the last call: it may still build the BVHs of clouds

    def of(self, world: World | None, self_collision: bool, number: Any, stream: Any) -> DeviceScene:
        """The scene of a world, for launches on a stream."""
        objects, clouds = self._parts.of(world)
        order(self._stream, stream)
        self._stream = stream
        last = self._last.get(number)
        if last is None or last[0] is not objects or last[1] is not clouds or last[2] is not self_collision:
            scene = self._checker.scene_among(objects, self_collision)
            last = self._last[number] = objects, clouds, self_collision, self._on_device(scene, clouds, number, stream)
        return last[3]

    def _on_device(self, scene: Scene, clouds: tuple[PlacedCloud, ...], number: Any, stream: Any) -> DeviceScene:
        numbers = None if clouds else few_numbers_below(scene.nodes, scene.root, MAX_ONE_BY_ONE)
        if numbers is None:
            number = np.float64  # float32 has too few digits for the places of nodes
            of_world, shapes = self._arena.of(scene, clouds, stream)
        else:
            number = number if scene.vertices is None else np.float64
            solids = table_of(scene.objects, scene.nodes, np.r_[scene.first : scene.end, numbers])
            nodes, shapes = np.empty((0, WIDTH)), np.unique(solids[:, SHAPE])
            scene = scene._replace(objects=solids, nodes=nodes, root=NO_NODE, first=0, end=len(solids))
            of_world = {name: device.on_device(_over(number, getattr(scene, name))) for name in _OF_ARENA}
        kind = BOXES if scene.vertices is None else ANY if _any_is_searched(scene, shapes) else CLOSED
        of_robot = {name: self._of_robot(name, getattr(scene, name), number) for name in _OF_ROBOT}
        sizes = self._checker.tree.n_dof, len(scene.joints), len(scene.bodies), kind, numbers is None
        return DeviceScene(device.Tables((scene._replace(**of_robot, **of_world),)), sizes, number, scene, clouds)

    def _of_robot(self, name: str, part: NDArray[Any] | None, number: Any) -> Any:
        """A table that belongs to the robot, on the device; copied again only if it is another one."""
        known = self._kept.get((name, number))
        if known is None or known[0] is not part:
            known = self._kept[name, number] = part, device.on_device(_over(number, part))
        return known[1]


class WorldParts:
    """A world as its large clouds, whose BVHs are built on the device, and tables of all other objects."""

    def __init__(self) -> None:
        self._world, self._number, self._found = None, -1, (NO_OBJECTS, ())
        self._tables, self._last = None, None

    def of(self, world: World | None) -> tuple[Objects, tuple[PlacedCloud, ...]]:
        """The tables, and the clouds: the same objects until the world changes."""
        refuse_no_world(world)
        if world is None:
            return NO_OBJECTS, ()
        if world is not self._world:
            self._world, self._number, self._tables = world, -1, None
        state = world.changed_since(self._number)
        if state is not None:
            self._found, self._number = self._of_state(world, state), state.number
        return self._found

    def _of_state(self, world: World, state: WorldState) -> tuple[Objects, tuple[PlacedCloud, ...]]:
        sizes = {name: len(shape.points) for name, shape in state.shapes.items() if isinstance(shape, PointCloud)}
        names = [name for name in sorted(sizes, key=sizes.__getitem__)[-MAX_CLOUDS:] if sizes[name] > MAX_ONE_BY_ONE]
        if not names:
            self._tables = None
            return world.objects(), ()
        clouds: dict[str, Any] = {name: state.shapes[name] for name in sizes if name in names}
        last = self._last if self._tables is not None else None
        self._tables = tables = self._tables or ObjectTables()
        shapes = {**state.shapes, **{name: self._emptied(name, cloud, last) for name, cloud in clouds.items()}}
        self._last = state._replace(shapes=shapes, poses={**state.poses, **dict.fromkeys(clouds, _ANYWHERE)})
        objects = self._found[0]
        changed = _changed(last, self._last)
        if changed or last is None:
            objects = tables.updated(changed, shapes, self._last.poses, state.touch_links)
        return objects, tuple(PlacedCloud(cloud, state.poses[name], tables.ball_row(name)) for name, cloud in clouds.items())

    @staticmethod
    def _emptied(name: str, cloud: PointCloud, last: WorldState | None) -> PointCloud:
        """A cloud without points, which has the row of the cloud's ball; the last one unless the radius changed."""
        known = None if last is None else last.shapes.get(name)
        if isinstance(known, PointCloud) and not len(known.points) and known.radius == cloud.radius:
            return known
        return PointCloud(np.empty((0, 3)), cloud.radius)


def _changed(before: WorldState | None, now: WorldState) -> dict[str, bool]:
    """The names of the objects that differ; True if more than the pose does."""
    if before is None:
        return dict.fromkeys(now.shapes, True)
    changed = {name: True for name in before.shapes if name not in now.shapes}
    for name, shape in now.shapes.items():
        links = before.touch_links.get(name) == now.touch_links.get(name)
        if before.shapes.get(name) is not shape or not links:
            changed[name] = True
        elif before.poses[name] is not now.poses[name]:
            changed[name] = False
    return changed


class ArenaCopy:
    """The arena of a world (``collision.arena``) and the BVHs of clouds on the device.

    An update copies what was appended to the arena since the last one, and builds the BVHs of the clouds that changed.
    """

    def __init__(self) -> None:
        self._copies: dict[str, tuple[Any, Any, int]] = {}  # the array of the arena, its copy, and the number of rows copied
        self._shapes: set[float] = set()
        self._trees = CloudTrees()

    def of(self, scene: Scene, clouds: tuple[PlacedCloud, ...], stream: Any) -> tuple[dict[str, Any], set[float]]:
        """The fields of a scene that belong to its world, on the device; and all shapes of solids that its arena has had."""
        table, points, nodes, root = scene.objects, scene.points, scene.nodes, scene.root
        objects, first = self._copied("objects", table, scene.end)
        self._shapes = (self._shapes if first else set()) | set(np.unique(table[first : scene.end, SHAPE]).tolist())
        there = device.on_device(_over(np.float64, None)) if points is None else self._copied("points", points, len(points))[0]
        room = NODE_ROWS * CloudTrees.room(clouds) if clouds else 0
        every, _ = self._copied("nodes", nodes, len(nodes), room)
        cuda.default_stream().synchronize()  # a launch on any other stream finds the copies complete
        if clouds:
            root = self._trees.write(clouds, root, every, _rows_of(nodes) // NODE_ROWS, stream)
        return {"objects": objects, "points": there, "nodes": every, "root": root}, self._shapes

    def _copied(self, name: str, part: NDArray[Any], end: int, room: int = 0) -> tuple[Any, int]:
        """The copy of an array up to a row, with room for further rows; and the first row that was copied now."""
        source, n = _source(part), _rows_of(part) + room
        known, there, first = self._copies.get(name, (None, None, 0))
        if known is not source or len(there) < n:  # cuda.device_array: its memory is freed only after all streams have read it
            there, first = cuda.device_array((max(1, n), part.shape[1]), part.dtype), 0
        if first < end:
            there[first:end].copy_to_device(part[first:end])
        self._copies[name] = source, there, max(first, end)
        return there, first


def _source(part: NDArray[Any]) -> NDArray[Any]:
    """The array of an arena that a part is a view of."""
    return part if part.base is None else part.base


def _rows_of(part: NDArray[Any]) -> int:
    """The number of rows that an arena has room for, those of a part and all after them."""
    return _source(part).size // part.shape[1]


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
