"""Writes the trees of AABBs over solids, and over trees (``kernels.collision.bvh``)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.arena import Arena
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import CHILD, NO_NODE, NODE_ROWS
from ulna.kernels.layout import CONTACT, HALF_EXTENTS, RADIUS

Array = NDArray[np.float64]
MOST_LEVELS = 11  # of a tree over 8^11 solids, more than memory holds
_NOWHERE = 1e300  # bounds that overlap no body


class ObjectTree(NamedTuple):
    """A tree in an arena.

    Attributes:
        root: The number of its root.
        n_levels: How many levels of nodes it has.
        low: The least x, y, z of all that is in it [m].
        high: The greatest.
    """

    root: int
    n_levels: int
    low: Array
    high: Array


def bounds(table: Array) -> tuple[Array, Array]:
    """The least and greatest x, y, z of each body of a table, with a margin for what touches it, shape (n, 3) each."""
    T, size = table[:, :12].reshape(-1, 3, 4), table[:, HALF_EXTENTS : RADIUS + 1].sum(axis=1)
    reach = (np.abs(T[:, :, :3]) * table[:, None, HALF_EXTENTS : HALF_EXTENTS + 3]).sum(axis=2) + table[:, RADIUS, None]
    reach += CONTACT * size[:, None]
    return T[:, :, 3] - reach, T[:, :, 3] + reach


def compact_order(centres: Array) -> NDArray[np.int64]:
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


def most_nodes(n: int) -> int:
    """How many nodes a tree over n solids, or trees, has at most."""
    return n // (WIDTH - 1) + MOST_LEVELS


def write_tree(arena: Arena, low: Array, high: Array, children: Array) -> ObjectTree:
    """Write a tree over bounds in the order given, shape (n, 3) each, n > 0.

    Args:
        arena: Where there is room for ``most_nodes``.
        low: The least x, y, z.
        high: The greatest.
        children: What is within the bounds, as a node says it, shape (n,).
    """
    n, n_levels = 0, 0
    while n != 1:
        n_levels += 1
        n = -(-len(children) // WIDTH)
        nodes = np.empty((n, NODE_ROWS, WIDTH))
        for first, sides, missing in ((0, low, _NOWHERE), (3, high, -_NOWHERE), (CHILD, children[:, None], np.nan)):
            filled = np.full((n * WIDTH, sides.shape[1]), missing)
            filled[: len(sides)] = sides
            nodes[:, first : first + sides.shape[1]] = filled.reshape(n, WIDTH, -1).swapaxes(1, 2)
        children = arena.add_nodes(nodes) + np.arange(float(n))
        low, high = nodes[:, :3].min(axis=2), nodes[:, 3:CHILD].max(axis=2)
    return ObjectTree(int(children[0]), n_levels, low[0], high[0])


def without(arena: Arena, tree: ObjectTree, place: int) -> ObjectTree:
    """A tree without what is in a place of the order in which it was written: new nodes from the root to that leaf."""
    node, root, last = tree.root, arena.n_nodes, tree.n_levels - 1
    for level in range(tree.n_levels):
        lane, first = place >> 3 * (last - level) & WIDTH - 1, NODE_ROWS * arena.n_nodes
        arena.nodes[first : first + NODE_ROWS] = arena.nodes[NODE_ROWS * node : NODE_ROWS * (node + 1)]
        arena.n_nodes += 1
        if level == last:
            column = arena.nodes[first : first + NODE_ROWS, lane]
            column[:3], column[3:CHILD], column[CHILD] = _NOWHERE, -_NOWHERE, np.nan
        else:
            node = int(arena.nodes[first + CHILD, lane])
            arena.nodes[first + CHILD, lane] = arena.n_nodes
    return tree._replace(root=root)


def rows_below(nodes: Array, root: int) -> NDArray[np.int64]:
    """The rows of the solids in a tree, shape (n,)."""
    found, below = [np.empty(0)], np.array([root] if root != NO_NODE else [])
    while len(below):
        children = nodes.reshape(-1, NODE_ROWS, WIDTH)[below.astype(np.int64), CHILD].ravel()
        found.append(-1 - children[children < 0])
        below = children[children >= 0]  # what is missing is neither
    return np.concatenate(found).astype(np.int64)
