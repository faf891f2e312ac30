"""Holds the tables of a world's objects as they were at one moment, and lists their solids.

A solid has a number (``kernels.collision.collision_layout``): a row of the table, or the place of a ball in a node.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import (
    BALL_ROW,
    CHILD,
    CHILDREN,
    FIRST_BALL,
    FIRST_POINTS,
    NO_NODE,
    NODE_ROWS,
    NOWHERE,
    PLACES,
)
from ulna.kernels.layout import HALF_SPACE, REACH, SHAPE

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


class Moving(NamedTuple):
    """An object that may move by itself.

    Attributes:
        name: The object's name.
        number: The object's number, in the rows of its solids.
        speed: The maximum speed of any of its points [m/s].
        n_updates: The number of its last pose update among all updates of its world.
        pose: T_base_object, shape (4, 4).
        radius: The radius of a ball about its frame's origin that holds it [m]; infinite for a half-space.
        in_tree: Whether it is in the BVH.
    """

    name: str
    number: int
    speed: float
    n_updates: int
    pose: Array
    radius: float
    in_tree: bool

    def max_displacement(self, pose: Array) -> float:
        """Upper bound on the distance that any of its points moved since another pose [m]."""
        rotation = self.pose[:3, :3] - pose[:3, :3]  # Frobenius norm: sqrt(2) times the spectral norm, which bounds motion
        translation = self.pose[:3, 3] - pose[:3, 3]
        return float(
            np.linalg.norm(translation) + (np.linalg.norm(rotation) / np.sqrt(2) * self.radius if rotation.any() else 0.0)
        )


@dataclass(eq=False, slots=True)
class Layout:
    """The tables of a world's objects. They stay valid while only unindexed objects move.

    Later calls may append rows, nodes and names, but change none.

    Attributes:
        table: The solids as the kernels read them (``kernels.layout``), shape (n, BODY_WIDTH). All balls of a cloud share a row.
        vertices: The vertices of all hulls, shape (m, 3).
        nodes: The nodes of trees (``kernels.collision.bvh``), shape (NODE_ROWS n_nodes, 8).
        root: The root of the BVH, or NO_NODE where no object is in one.
        only_boxes: Whether all shapes are boxes.
        touch_sets: The sets of links that may touch objects, by their numbers in the table; the first is empty.
        names: The object's name, by the object number in a solid's row.
        clouds: The clouds by name, each with the number of the first node of its points.
    """

    table: NDArray[np.float64]
    vertices: NDArray[np.float64]
    nodes: NDArray[np.float64]
    root: int
    only_boxes: bool
    touch_sets: tuple[frozenset[str], ...]
    names: list[str]
    clouds: dict[str, tuple[PointCloud, int]]


@dataclass(eq=False, slots=True)
class Objects:
    """The solids of a world's objects as they were at one moment. They never change.

    Attributes:
        layout: Their tables. The solids are the rows from ``first`` to before ``end``, and those below the root of the BVH.
        first: The first row of the solids that are not in the BVH.
        end: The row after the last of them.
        moving: The objects that may move by themselves.
        n_changes: The number of changes of the world, without pose updates of these objects.
    """

    layout: Layout
    first: int
    end: int
    moving: tuple[Moving, ...] = ()
    n_changes: int = 0

    def ball(self, name: str, number: int) -> tuple[PointCloud, int] | None:
        """The cloud of a solid that is a ball, and the ball's place in its tree; None for other solids."""
        if number < FIRST_BALL:
            return None
        cloud, first = self.layout.clouds[name]
        return cloud, number - FIRST_BALL - 2 * WIDTH * first

    @property
    def numbers(self) -> NDArray[np.int64]:
        """The numbers of all solids (``kernels.collision.collision_layout``)."""
        return np.concatenate([np.arange(self.first, self.end), numbers_below(self.layout.nodes, self.layout.root)])

    @property
    def solids(self) -> NDArray[np.float64]:
        """All solids as rows of a table, shape (n, BODY_WIDTH)."""
        return table_of(self.layout.table, self.layout.nodes, self.numbers)

    @property
    def farthest(self) -> float:
        """The maximum distance of the objects from the base's origin, half-spaces aside [m]; 0 without objects."""
        table = self.solids
        bounded = table[table[:, SHAPE] != HALF_SPACE]
        return float(np.max(np.linalg.norm(bounded[:, 3:12:4], axis=1) + bounded[:, REACH], initial=0.0))


def numbers_below(nodes: Array, root: int) -> Numbers:
    """The numbers of the solids in a tree, shape (n,)."""
    numbers = few_numbers_below(nodes, root, 1 << 62)
    assert numbers is not None  # noqa: S101 - a tree has fewer
    return numbers


def few_numbers_below(nodes: Array, root: int, at_most: int) -> Numbers | None:
    """The numbers of the solids in a tree, shape (n,), or None if there are more than ``at_most``."""
    found, below = [np.empty(0, np.int64)], np.array([root] if root != NO_NODE else [], dtype=np.int64)
    while len(below):
        if sum(map(len, found)) + len(below) > at_most:
            return None
        number, kind = below // PLACES, below % PLACES
        of_points = kind != CHILDREN
        found.append(_balls_in(nodes, number[of_points], kind[of_points] - FIRST_POINTS))
        children = nodes.reshape(-1, NODE_ROWS, WIDTH)[number[~of_points], CHILD].ravel()
        children = children[~np.isnan(children)].astype(np.int64)
        found.append(-1 - children[children < 0])
        below = children[children >= 0]
    numbers = np.concatenate(found)
    return numbers if len(numbers) <= at_most else None


def rows_of(nodes: Array, numbers: Numbers) -> Numbers:
    """The row of the table with the size, the object and the touch set of each solid, shape (n,)."""
    rows, is_ball = numbers.copy(), numbers >= FIRST_BALL
    number = (numbers[is_ball] - FIRST_BALL) // (2 * WIDTH)
    rows[is_ball] = nodes.reshape(-1, NODE_ROWS, WIDTH)[number, CHILD, BALL_ROW]
    return rows


def table_of(table: Array, nodes: Array, numbers: Numbers) -> Array:
    """Solids as rows of a new table, shape (n, BODY_WIDTH)."""
    solids, is_ball = table[rows_of(nodes, numbers)], numbers >= FIRST_BALL
    number, place = np.divmod(numbers[is_ball] - FIRST_BALL, 2 * WIDTH)
    second, lane = np.divmod(place, WIDTH)
    for axis in range(3):
        solids[is_ball, 3 + 4 * axis] = nodes[NODE_ROWS * number + 3 * second + axis, lane]
    return solids


def _balls_in(nodes: Array, number: Numbers, second: Numbers) -> Numbers:
    """The numbers of the balls in the first or the second half of nodes of points."""
    lanes = np.arange(WIDTH)
    present = nodes[NODE_ROWS * number + 3 * second] < NOWHERE
    return (FIRST_BALL + (2 * WIDTH * number + WIDTH * second)[:, None] + lanes)[present]
