"""Makes the tables of a world's objects, and a BVH over them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.collision.expand import Solids, expand
from ulna.description.clouds import Obstacle
from ulna.description.robot_description import frozen
from ulna.description.shapes import HalfSpace
from ulna.engine.lanes import WIDTH
from ulna.kernels.layout import BASE, BODY_WIDTH, BOX, CONTACT, FIRST_VERTEX, HALF_EXTENTS, HALF_SPACE, RADIUS, REACH, SHAPE

MOST_UNINDEXED = 64  # worlds of at most this many objects need no BVH: testing each for eight configurations at once is as fast
_NOWHERE = 1e300  # bounds that overlap no body


@dataclass(frozen=True, eq=False)
class Objects:
    """The solids that the objects of a world consist of.

    Attributes:
        names: In the order of the table, for each solid that of the object which it is part of.
        table: What the kernels read of each (``kernels.layout``), shape (n, BODY_WIDTH).
        vertices: Those of all hulls, shape (m, 3).
        nodes: The BVH of the objects from ``n_unindexed`` on (``kernels.collision.bvh``), shape (6 n_nodes, 8); empty if none is
            indexed.
        n_unindexed: How many solids, the first of the table, are not in the BVH.
        only_boxes: Whether all shapes are boxes.
        touch_sets: The sets of links that may touch objects, by the numbers in the table; the first is empty.
    """

    names: tuple[str, ...]
    table: NDArray[np.float64]
    vertices: NDArray[np.float64]
    nodes: NDArray[np.float64]
    n_unindexed: int
    only_boxes: bool
    touch_sets: tuple[frozenset[str], ...]

    @property
    def farthest(self) -> float:
        """How far from the base's origin the objects reach, half-spaces aside [m]; 0 if there are none."""
        bounded = self.table[self.table[:, SHAPE] != HALF_SPACE]
        return float(np.max(np.linalg.norm(bounded[:, 3:12:4], axis=1) + bounded[:, REACH], initial=0.0))


def make_objects(
    shapes: Mapping[str, Obstacle], poses: Mapping[str, NDArray[np.float64]], touch_links: Mapping[str, frozenset[str]]
) -> Objects:
    """Named shapes at poses T_base_object, and the links that may touch each of some."""
    sets = tuple(dict.fromkeys([frozenset[str](), *touch_links.values()]))
    kinds = sorted(shapes, key=lambda name: not isinstance(shapes[name], HalfSpace))
    parts = [expand(shapes[name]) for name in kinds]
    names = [name for name, part in zip(kinds, parts, strict=True) for _ in part.places]
    vertices = [part.vertices for part in parts]
    first = np.cumsum([0, *map(len, vertices)])[:-1]
    rows = [
        _rows(poses[name], part, k, sets.index(touch_links.get(name, frozenset())))
        for name, part, k in zip(kinds, parts, first, strict=True)
    ]
    table = np.concatenate([np.empty((0, BODY_WIDTH)), *rows])
    n_endless = sum(isinstance(shapes[name], HalfSpace) for name in kinds)
    n_unindexed = len(table) if len(table) <= MOST_UNINDEXED else n_endless
    low, high = bounds(table[n_unindexed:])
    order = np.concatenate([np.arange(n_unindexed), n_unindexed + compact_order((low + high) / 2)])
    nodes = tree_of_bounds(low[order[n_unindexed:] - n_unindexed], high[order[n_unindexed:] - n_unindexed])
    points = np.concatenate([np.zeros((0, 3)), *vertices])
    only_boxes = bool((table[:, SHAPE] == BOX).all())
    table, points = frozen(table[order], table.shape), frozen(points, points.shape)  # as a robot's: kernels know one kind of both
    return Objects(tuple(names[k] for k in order), table, points, nodes, n_unindexed, only_boxes, sets)


def _rows(T: NDArray[np.float64], parts: Solids, first_vertex: int, touch_set: int) -> NDArray[np.float64]:
    """The rows of the solids of an object at a pose T_base_object."""
    rows = np.empty((len(parts.places), BODY_WIDTH))
    rows[:, :12], rows[:, 12:14], rows[:, 14:] = T[:3].ravel(), (BASE, touch_set), parts.columns
    rows[:, 3:12:4] += parts.places @ T[:3, :3].T
    rows[:, FIRST_VERTEX] = first_vertex
    return rows


def bounds(table: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The least and greatest x, y, z of each body of a table, with a margin for what touches it, shape (n, 3) each."""
    T, size = table[:, :12].reshape(-1, 3, 4), table[:, HALF_EXTENTS : RADIUS + 1].sum(axis=1)
    reach = (np.abs(T[:, :, :3]) * table[:, None, HALF_EXTENTS : HALF_EXTENTS + 3]).sum(axis=2) + table[:, RADIUS, None]
    reach += CONTACT * size[:, None]
    return T[:, :, 3] - reach, T[:, :, 3] + reach


def compact_order(centres: NDArray[np.float64]) -> NDArray[np.int64]:
    """An order in which every node of the tree holds objects that are near each other.

    From the root down, the objects of a node are halved across its longest side, and the halves twice more, for eight children;
    all nodes of a level at once. Source: Bentley, Multidimensional binary search trees (Communications of the ACM, 1975).
    """
    n = len(centres)
    size = 1 << max(n - 1, 0).bit_length()
    filled = np.full((3, size), np.inf)  # the padding is farthest in every direction, so it is sorted last
    filled[:, :n] = centres.T
    order = np.arange(size)
    while size > WIDTH:
        places = filled[:, order].reshape(3, -1, size)
        spread = np.where(places < np.inf, places, -np.inf).max(axis=2) - places.min(axis=2)
        across = np.take_along_axis(places, spread.argmax(axis=0)[None, :, None], axis=0)[0]
        size //= 2
        halves = np.argpartition(across, size, axis=1)
        order = np.take_along_axis(order.reshape(halves.shape), halves, axis=1).ravel()
    return order[order < n]


def tree_of_bounds(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nodes of a complete tree, eight children each, over bounds in the order given (``kernels.collision.bvh``)."""
    levels = []
    while len(low) and (not levels or len(low) > 1):
        n = -(-len(low) // WIDTH)
        low, high = _filled_up(low, n * WIDTH, _NOWHERE), _filled_up(high, n * WIDTH, -_NOWHERE)
        sides = [side.reshape(n, WIDTH, 3).swapaxes(1, 2) for side in (low, high)]
        levels.append(np.concatenate(sides, axis=1))
        low, high = sides[0].min(axis=2), sides[1].max(axis=2)
    nodes = np.empty((0, 6, WIDTH))
    for level, sides in enumerate(reversed(levels)):
        nodes = np.concatenate([_filled_up(nodes, (WIDTH**level - 1) // (WIDTH - 1), 0.0), sides])
    return nodes.reshape(-1, WIDTH)


def _filled_up(rows: NDArray[np.float64], n: int, value: float) -> NDArray[np.float64]:
    """The rows, padded with rows of one value to n rows."""
    return np.concatenate([rows, np.full((n - len(rows), *rows.shape[1:]), value)])
