"""Puts a robot and all objects of a world into one scene, those that some links may touch too. Used by ``planner``."""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.objects import Objects
from ulna.collision.touchable import scene_of
from ulna.collision.world import World
from ulna.description.robot_description import frozen
from ulna.kernels.collision.scene import Scene
from ulna.kernels.layout import BODY_WIDTH, FIRST_VERTEX, HALF_SPACE, REACH, SHAPE
from ulna.planning.slices import Pace

Array = NDArray[np.float64]


class MergedScene(NamedTuple):
    """A scene, and which body may touch which unindexed object, shape (n_bodies, n_unindexed)."""

    scene: Scene
    may_touch: NDArray[np.bool_]


def merged_scene(checker: Checker, objects: Objects) -> MergedScene:
    """The scene of a world. The objects that some links may touch come first, and are not in the BVH."""
    bodies = checker.bodies
    if not objects.touchable:
        scene = scene_of(checker.tree.joints, bodies, checker.pairs, objects)
        return MergedScene(scene, np.zeros((len(bodies.table), objects.n_unindexed), dtype=bool))
    parts = [some for _, some in objects.touchable]
    tables, vertices = [*(part.table for part in parts), objects.table], [*(part.vertices for part in parts), objects.vertices]
    table = np.concatenate([np.empty((0, BODY_WIDTH)), *tables])
    first = np.concatenate([np.full(len(rows), n) for rows, n in zip(tables, _starts(vertices), strict=True)])
    table[:, FIRST_VERTEX] += first
    n_touchable = sum(len(part.table) for part in parts)
    points = np.concatenate(vertices)
    whole = Objects(
        names=(),
        table=frozen(table, table.shape),
        vertices=frozen(points, points.shape),
        nodes=objects.nodes,
        n_unindexed=n_touchable + objects.n_unindexed,
        only_boxes=objects.only_boxes and all(part.only_boxes for part in parts),
    )
    may_touch = np.zeros((len(bodies.table), whole.n_unindexed), dtype=bool)
    at = 0
    for links, some in objects.touchable:
        rows = [k for k, owner in enumerate(bodies.owners) if owner in links]
        may_touch[rows, at : at + len(some.table)] = True
        at += len(some.table)
    return MergedScene(scene_of(checker.tree.joints, bodies, checker.pairs, whole), may_touch)


_kept: WeakKeyDictionary[Checker, tuple[Objects, MergedScene, Pace]] = WeakKeyDictionary()


def kept_scene(checker: Checker, objects: Objects) -> tuple[MergedScene, Pace]:
    """The scene of a world, and how many edges a slice has in it, which is learnt. Those of a robot's last world are kept."""
    kept = _kept.get(checker)
    if kept is None or kept[0] is not objects:
        kept = _kept[checker] = objects, merged_scene(checker, objects), Pace()
    return kept[1:]


def _starts(vertices: list[Array]) -> list[int]:
    return np.cumsum([0, *map(len, vertices)])[:-1].tolist()


def farthest(world: World | None) -> float:
    """How far from the base's origin the objects of a world reach, half-spaces aside [m]; 0 if there are none."""
    if world is None:
        return 0.0
    objects = world.objects()
    tables = [objects.table, *(each.table for _, each in objects.touchable)]
    far = [np.linalg.norm(table[:, 3:12:4], axis=1) + table[:, REACH] for table in tables]
    bounded = [table[:, SHAPE] != HALF_SPACE for table in tables]
    return float(max((np.max(x[keep], initial=0.0) for x, keep in zip(far, bounded, strict=True)), default=0.0))
