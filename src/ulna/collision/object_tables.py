"""Keeps the tables of a world's objects, and rewrites only what a change of an object requires.

Written rows of an arena never change, so a running query still sees the world before the change.

- A cloud, a height map and a voxel grid have rows and a tree of their own. Both are rewritten only if the object itself moves.
- Of the other objects, up to MAX_UNINDEXED are tested one by one: those added or moved last. Their rows are rewritten after each
  change, which takes a microsecond. If there are more, a tree is built over all of these objects.
- An object that moves leaves this tree, and is tested alone from then on. The nodes on its path to the root are copied.
- A last tree joins all of these trees.

When the arena is full, the rows in use are copied to a new arena.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.arena import Arena
from ulna.collision.clouds import PointCloud
from ulna.collision.grids import HeightMap, Obstacle, VoxelGrid
from ulna.collision.object_tree import (
    MAX_LEVELS,
    NO_TREE,
    ObjectTree,
    bounds,
    compact_order,
    max_cloud_nodes,
    max_nodes,
    median_split_order,
    remove_child,
    write_cloud,
    write_tree,
)
from ulna.collision.objects import Layout, Moving, Objects
from ulna.collision.rounded_shapes import shape_columns, shape_vertices
from ulna.description.shapes import Box, HalfSpace, Sphere
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import BALL_ROW, CHILD, NO_NODE, NODE_ROWS, PLACES
from ulna.kernels.layout import (
    BODY_WIDTH,
    BOX,
    FIRST_VERTEX,
    HALF_EXTENTS,
    HULL,
    N_VERTICES,
    OBJECT,
    RADIUS,
    REACH,
    SHAPE,
    TOUCH_SET,
)

Array = NDArray[np.float64]
MAX_UNINDEXED = 64  # up to this number, testing all objects for eight configurations at once is as fast as a BVH
_SPARE = 4096  # spare rows and nodes of an arena: as many moves among a few objects
_NO_LINKS = frozenset[str]()


class _Compound(NamedTuple):
    """An object of many solids, with its rows and nodes in the arena."""

    shape: PointCloud | HeightMap | VoxelGrid
    touch_set: int
    rows: slice  # a cloud has one row: the ball
    nodes: slice  # nodes of points first
    n_of_points: int  # number of nodes that hold points
    tree: ObjectTree


class ObjectTables:
    """The tables of the objects of one world."""

    def __init__(self) -> None:
        """Begin with an empty world."""
        self._arena = Arena()
        self._rows = np.empty((WIDTH, BODY_WIDTH))  # of the objects tested one by one, as they will be in the arena
        self._unindexed: dict[str, int] = {}  # the row of each of them
        self._indexed: dict[str, tuple[int, int]] = {}  # the row, and the place in the tree, of each object in the tree
        self._tree = NO_TREE  # over the indexed objects
        self._compounds: dict[str, _Compound] = {}
        self._farthest: dict[str, float] = {}  # radius about the frame's origin, of those of _many that have a speed [m]
        self._unbounded: set[str] = set()
        self._not_boxes: set[str] = set()  # shapes other than boxes
        self._sets = {_NO_LINKS: 0}
        self._root: int | None = NO_NODE  # None: the trees have changed
        self._layout: Layout | None = None  # of the last objects

    def copy(self) -> "ObjectTables":
        """An independent copy; both write to the same arena."""
        other = ObjectTables()
        other.__dict__.update({name: value.copy() if hasattr(value, "copy") else value for name, value in self.__dict__.items()})
        return other

    def updated(
        self,
        changed: Mapping[str, bool],
        shapes: Mapping[str, Obstacle],
        poses: Mapping[str, Array],
        touch_links: Mapping[str, frozenset[str]],
    ) -> Objects:
        """The objects after a change.

        Args:
            changed: The names of the objects that changed since the last call; True if more than the pose changed.
            shapes: The shapes of all objects.
            poses: Their poses T_base_object.
            touch_links: The links that may touch an object, by its name.
        """
        with self._arena.lock:
            layout, unindexed, arena = self._layout, self._unindexed, self._arena
            only_moved = changed.keys() <= unindexed.keys() and not any(changed.values())
            if layout is not None and only_moved and arena.n_rows + len(unindexed) <= len(arena.table):
                for name in changed:
                    self._rows[unindexed[name], :12] = poses[name].ravel()[:12]
            else:
                layout = self._layout = self._make_layout(changed, shapes, poses, touch_links)
                arena = self._arena
            first = arena.add_rows(self._rows[: len(self._unindexed)])
            return Objects(layout, first, arena.n_rows)

    def _make_layout(
        self,
        changed: Mapping[str, bool],
        shapes: Mapping[str, Obstacle],
        poses: Mapping[str, Array],
        touch_links: Mapping[str, frozenset[str]],
    ) -> Layout:
        """The layout after any change, with room in the arena for the rows of the objects that are tested alone."""
        if sum(name in self._indexed for name, remade in changed.items() if not remade) > MAX_UNINDEXED:
            self._dissolve_tree()
        for name, remade in changed.items():
            if not remade:
                self._move(name, poses[name])
                continue
            self._remove(name)
            if name in shapes:
                self._add(name, shapes[name], poses[name], touch_links.get(name, _NO_LINKS))
        if len(self._unindexed) - len(self._unbounded) > MAX_UNINDEXED:
            self._index()
        self._reserve(len(self._unindexed), 0, max_nodes(len(self._compounds) + 1))
        if self._root is None:
            self._root = self._join_trees()
        arena, boxes, sets = self._arena, not self._not_boxes, tuple(self._sets)
        clouds = {
            name: (one.shape, one.nodes.start) for name, one in self._compounds.items() if isinstance(one.shape, PointCloud)
        }
        table, vertices = arena.read_only
        written = vertices[: arena.n_vertices], arena.nodes[: NODE_ROWS * arena.n_nodes]
        return Layout(table, *written, self._root, boxes, sets, arena.names, clouds)

    def moving(self, speeds: Mapping[str, float], n_updates: Mapping[str, int], poses: Mapping[str, Array]) -> tuple[Moving, ...]:
        """The objects that have a speed, after ``updated``."""
        found = []
        for name, speed in speeds.items():
            if name in self._compounds:
                one = self._compounds[name]
                if one.rows.start == one.rows.stop:  # the object is empty
                    continue
                if name not in self._farthest:
                    self._farthest[name] = _farthest(one.shape)
                row, radius = self._arena.table[one.rows.start], self._farthest[name]
            else:
                row = self._rows[self._unindexed[name]] if name in self._unindexed else self._arena.table[self._indexed[name][0]]
                radius = float(row[REACH])
            found.append(Moving(name, int(row[OBJECT]), speed, n_updates[name], poses[name], radius, name not in self._unindexed))
        return tuple(found)

    def ball_row(self, name: str) -> int:
        """The row of a cloud's ball in the last layout."""
        return self._compounds[name].rows.start

    def _add(self, name: str, shape: Obstacle, T: Array, links: frozenset[str]) -> None:
        touch_set = self._sets.setdefault(links, len(self._sets))
        if not isinstance(shape, Box | HeightMap | VoxelGrid):
            self._not_boxes.add(name)
        if isinstance(shape, PointCloud | HeightMap | VoxelGrid):
            self._add_compound(name, touch_set, T, shape)
            return
        vertices = shape_vertices(shape)
        self._reserve(0, len(vertices))
        arena = self._arena
        first = arena.add_vertices(vertices) if len(vertices) else 0
        row = (*T[:3].ravel().tolist(), arena.add_name(name), touch_set, *shape_columns(shape, first))
        self._append_unindexed(name, row)
        if isinstance(shape, HalfSpace):
            self._unbounded.add(name)

    def _append_unindexed(self, name: str, row: ArrayLike) -> None:
        """Append an object with this row to those that are tested alone."""
        n = len(self._unindexed)
        if n == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[n], self._unindexed[name] = row, n

    def _add_compound(self, name: str, touch_set: int, T: Array, shape: PointCloud | HeightMap | VoxelGrid) -> None:
        if isinstance(shape, PointCloud):
            n, n_of_points = len(shape.points), -(-len(shape.points) // (2 * WIDTH))
            number, first_row, first_node = self._begin_compound(name, 1, max_cloud_nodes(n))
            row = (*np.eye(4)[:3].ravel().tolist(), number, touch_set, *shape_columns(Sphere(shape.radius)))
            at = self._arena.add_rows(np.array([row]))
            tree = write_cloud(self._arena, shape, T, at) if n else NO_TREE
        else:
            centers, half = shape.boxes
            n, n_of_points = len(centers), 0
            number, first_row, first_node = self._begin_compound(name, n, max_nodes(n))
            tree = write_tree(self._arena, *self._add_boxes(number, touch_set, T, centers, half)) if n else NO_TREE
        rows, nodes = slice(first_row, self._arena.n_rows), slice(first_node, self._arena.n_nodes)
        self._compounds[name], self._root = _Compound(shape, touch_set, rows, nodes, n_of_points, tree), None

    def _begin_compound(self, name: str, n_rows: int, n_nodes: int) -> tuple[int, int, int]:
        """Make room for an object of many solids; its number, and its first row and node."""
        self._reserve(n_rows, 0, n_nodes)
        return self._arena.add_name(name), self._arena.n_rows, self._arena.n_nodes

    def _add_boxes(self, number: int, touch_set: int, T: Array, centers: Array, half: Array) -> tuple[Array, Array, Array]:
        """Write the rows of the boxes of an object; the arguments of ``write_tree`` for them."""
        order = compact_order(centers)
        rows = np.zeros((len(order), BODY_WIDTH))
        rows[:, :12], rows[:, OBJECT], rows[:, TOUCH_SET], rows[:, SHAPE] = T[:3].ravel(), number, touch_set, BOX
        rows[:, HALF_EXTENTS:RADIUS], rows[:, REACH] = half[order], np.linalg.norm(half[order], axis=1)
        rows[:, 3:12:4] += centers[order] @ T[:3, :3].T
        first = self._arena.add_rows(rows)
        return *bounds(rows), -1.0 - np.arange(float(first), first + len(rows))

    def _move(self, name: str, T: Array) -> None:
        if name in self._compounds:
            one = self._compounds.pop(name)
            self._add_compound(name, one.touch_set, T, one.shape)
            return
        if name in self._indexed:
            self._append_unindexed(name, self._remove_from_tree(name))
        self._rows[self._unindexed[name], :12] = T[:3].ravel()

    def _remove(self, name: str) -> None:
        if name in self._indexed:
            self._remove_from_tree(name)
        if self._compounds.pop(name, None):
            self._root = None
            self._farthest.pop(name, None)
        if name in self._unindexed:
            k, n = self._unindexed.pop(name), len(self._unindexed)
            self._rows[k:n] = self._rows[k + 1 : n + 1]
            self._unindexed = {name: k for k, name in enumerate(self._unindexed)}
        self._unbounded.discard(name)
        self._not_boxes.discard(name)

    def _remove_from_tree(self, name: str) -> Array:
        """Remove an object from the tree; its row."""
        self._reserve(0, 0, MAX_LEVELS)
        row, place = self._indexed.pop(name)
        self._tree, self._root = remove_child(self._arena, self._tree, place), None
        return self._arena.table[row]

    def _dissolve_tree(self) -> None:
        """Move all objects of the tree to those that are tested alone, since so many of them move."""
        n, rows = len(self._unindexed), self._arena.table[[row for row, _ in self._indexed.values()]]
        self._rows = np.concatenate([self._rows[:n], rows])
        self._unindexed |= {name: n + k for k, name in enumerate(self._indexed)}
        self._indexed, self._tree, self._root = {}, NO_TREE, None

    def _index(self) -> None:
        """Build a tree over all bounded objects of one solid."""
        n = len(self._indexed) + len(self._unindexed)
        self._reserve(n, 0, max_nodes(n))
        bounded = {name: k for name, k in self._unindexed.items() if name not in self._unbounded}
        rows = np.concatenate([self._arena.table[[row for row, _ in self._indexed.values()]], self._rows[[*bounded.values()]]])
        names, (low, high) = [*self._indexed, *bounded], bounds(rows)
        order = median_split_order((low + high) / 2)
        first = self._arena.add_rows(rows[order])  # in the order of the tree, for fewer cache misses
        self._tree = write_tree(self._arena, low[order], high[order], -1.0 - np.arange(float(first), first + len(rows)))
        self._indexed = {names[k]: (first + place, place) for place, k in enumerate(order.tolist())}
        unbounded = [name for name in self._unindexed if name in self._unbounded]
        self._rows[: len(unbounded)] = self._rows[[self._unindexed[name] for name in unbounded]]
        self._unindexed, self._root = {name: k for k, name in enumerate(unbounded)}, None

    def _join_trees(self) -> int:
        """The root of a tree over all trees, or NO_NODE without trees. The arena must have room for its nodes."""
        trees = [one.tree for one in self._compounds.values() if one.tree is not NO_TREE] + [self._tree] * bool(self._indexed)
        if len(trees) < 2:
            return trees[0].root if trees else NO_NODE
        low, high = np.array([tree.low for tree in trees]), np.array([tree.high for tree in trees])
        order = compact_order((low + high) / 2)
        roots = np.array([float(tree.root) for tree in trees])
        return write_tree(self._arena, low[order], high[order], roots[order]).root

    def _reserve(self, n_rows: int, n_vertices: int = 0, n_nodes: int = 0) -> None:
        """Copy everything in use to a new arena, unless this one has room for as many more."""
        old = self._arena
        if old.has_room(n_rows, n_vertices, n_nodes):
            return
        names = [*self._unindexed, *self._indexed]
        rows = np.concatenate([self._rows[: len(self._unindexed)], old.table[[row for row, _ in self._indexed.values()]]])
        hulls = np.flatnonzero(rows[:, SHAPE] == HULL)
        compounds = self._compounds.values()
        n = len(rows) + sum(one.rows.stop - one.rows.start for one in compounds)
        in_use = max_nodes(len(rows)) + sum(one.nodes.stop - one.nodes.start for one in compounds)
        n_points = int(rows[hulls, N_VERTICES].sum())
        new = self._arena = Arena(2 * (n + n_rows) + _SPARE, 2 * (n_points + n_vertices), 2 * (in_use + n_nodes) + _SPARE)
        for k in hulls:
            first = int(rows[k, FIRST_VERTEX])
            rows[k, FIRST_VERTEX] = new.add_vertices(old.vertices[first : first + int(rows[k, N_VERTICES])])
        rows[:, OBJECT] = [new.add_name(name) for name in names]
        for name, one in self._compounds.items():
            self._compounds[name] = _copy_compound(old, new, one, new.add_name(name))
        is_indexed, self._indexed, self._root = bool(self._indexed), {}, None
        self._rows, self._unindexed = (
            np.concatenate([rows, np.empty((WIDTH, BODY_WIDTH))]),
            {name: k for k, name in enumerate(names)},
        )
        if is_indexed:
            self._index()


def _farthest(shape: PointCloud | HeightMap | VoxelGrid) -> float:
    """The radius of an object of many solids about its frame's origin [m]."""
    if isinstance(shape, PointCloud):
        return float(np.linalg.norm(shape.points, axis=1).max(initial=0.0)) + shape.radius
    return float((np.linalg.norm(shape.boxes[0], axis=1) + np.linalg.norm(shape.boxes[1], axis=1)).max(initial=0.0))


def make_objects(
    shapes: Mapping[str, Obstacle], poses: Mapping[str, Array], touch_links: Mapping[str, frozenset[str]]
) -> Objects:
    """Objects of named shapes at poses T_base_object, with the links that may touch some of them."""
    return ObjectTables().updated(dict.fromkeys(shapes, True), shapes, poses, touch_links)


def _copy_compound(old: Arena, new: Arena, compound: _Compound, number: int) -> _Compound:
    """Copy the rows and nodes of an object to another arena, where it has this number."""
    rows = old.table[compound.rows].copy()
    rows[:, OBJECT] = number
    row_shift = new.add_rows(rows) - compound.rows.start
    first = new.add_nodes(old.nodes.reshape(-1, NODE_ROWS, WIDTH)[compound.nodes])
    node_shift, nodes = (
        first - compound.nodes.start,
        new.nodes[NODE_ROWS * first : NODE_ROWS * new.n_nodes].reshape(-1, NODE_ROWS, WIDTH),
    )
    nodes[: compound.n_of_points, CHILD, BALL_ROW] += row_shift
    children = nodes[compound.n_of_points :, CHILD]
    children += np.where(children < 0, -row_shift, PLACES * node_shift)
    tree = compound.tree if compound.tree is NO_TREE else compound.tree._replace(root=compound.tree.root + PLACES * node_shift)
    slices = slice(compound.rows.start + row_shift, compound.rows.stop + row_shift), slice(first, new.n_nodes)
    return _Compound(compound.shape, compound.touch_set, *slices, compound.n_of_points, tree)


NO_OBJECTS = make_objects({}, {}, {})
