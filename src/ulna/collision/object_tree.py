"""Writes BVHs of AABBs over solids, and over other trees (``kernels.collision.bvh``)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.arena import Arena
from ulna.collision.clouds import PointCloud
from ulna.collision.entries import morton_order, tree_nodes
from ulna.engine.lanes import WIDTH
from ulna.kernels.collision.collision_layout import CHILD, NO_NODE, NODE_ROWS, NOWHERE, PLACES
from ulna.kernels.layout import CONTACT, HALF_EXTENTS, RADIUS

Array = NDArray[np.float64]
MAX_LEVELS = 11  # of a tree over 8^11 solids, more than memory holds


class ObjectTree(NamedTuple):
    """A tree in an arena.

    Attributes:
        root: The place of its root.
        n_levels: The number of levels of its nodes of AABBs; nodes of points do not count.
        low: The minimum x, y, z of its contents [m].
        high: The maximum x, y, z [m].
    """

    root: int
    n_levels: int
    low: Array
    high: Array


NO_TREE = ObjectTree(NO_NODE, 0, np.empty(0), np.empty(0))


def bounds(table: Array) -> tuple[Array, Array]:
    """The AABB of each body of a table, with a margin for contacts: minimum and maximum, shape (n, 3) each."""
    T, size = table[:, :12].reshape(-1, 3, 4), table[:, HALF_EXTENTS : RADIUS + 1].sum(axis=1)
    reach = (np.abs(T[:, :, :3]) * table[:, None, HALF_EXTENTS : HALF_EXTENTS + 3]).sum(axis=2) + table[:, RADIUS, None]
    reach += CONTACT * size[:, None]
    return T[:, :, 3] - reach, T[:, :, 3] + reach


def compact_order(centers: NDArray[np.floating]) -> NDArray[np.int64]:
    """An order of points in which each node of a tree holds neighbors; a cloud's tree has this order."""
    order, read_only = np.empty(len(centers), np.int64), np.ascontiguousarray(centers).view()
    read_only.setflags(write=False)  # read-only, as are the points of a cloud: the entry is compiled for read-only arrays
    morton_order.morton_order(read_only, order)
    return order


def median_split_order(centers: Array) -> NDArray[np.int64]:
    """An order for trees that are searched often.

    The AABBs of its nodes overlap less than in ``compact_order``, which takes less time to compute.

    From the root down, a node's objects are halved across its longest side, and the halves are halved twice more, into eight
    children. All nodes of a level are halved at once. Source: Bentley, Multidimensional binary search trees (Communications of
    the ACM, 1975).
    """
    n = len(centers)
    size = 1 << max(n - 1, 0).bit_length()
    padded = np.full((3, size), np.inf)  # the padding is farthest in every direction, so it is sorted last
    padded[:, :n] = centers.T
    order = np.arange(size)
    while size > WIDTH:
        sorted_centers = padded[:, order].reshape(3, -1, size)
        spread = np.where(sorted_centers < np.inf, sorted_centers, -np.inf).max(axis=2) - sorted_centers.min(axis=2)
        along_longest = np.take_along_axis(sorted_centers, spread.argmax(axis=0)[None, :, None], axis=0)[0]
        size //= 2
        halves = np.argpartition(along_longest, size, axis=1)
        order = np.take_along_axis(order.reshape(halves.shape), halves, axis=1).ravel()
    return order[order < n]


def max_nodes(n: int) -> int:
    """The maximum number of nodes of a tree over n solids, or over n trees."""
    return n // (WIDTH - 1) + MAX_LEVELS


def max_cloud_nodes(n: int) -> int:
    """The maximum number of nodes of a tree over n points of a cloud."""
    return n // (2 * WIDTH) + 1 + max_nodes(n // WIDTH + 1)


def write_tree(arena: Arena, low: Array, high: Array, children: Array) -> ObjectTree:
    """Write a tree over bounds in the given order, shape (n, 3) each, n > 0.

    Args:
        arena: The arena to write to, with room for ``max_nodes``.
        low: The minimum x, y, z.
        high: The maximum x, y, z.
        children: The child within each bound, as a node encodes it, shape (n,).
    """
    n_nodes = tree_nodes.write_tree(low, high, children, arena.nodes, arena.n_nodes)
    return _tree_at_end(arena, n_nodes, -(-len(children) // WIDTH))


def write_cloud(arena: Arena, cloud: PointCloud, T: Array, row: int) -> ObjectTree:
    """Write the tree of a cloud at a pose T_base_cloud, shape (4, 4).

    Args:
        arena: The arena to write to, with room for ``max_cloud_nodes``.
        cloud: The points.
        T: Their pose.
        row: The row of the cloud's ball in the arena's table.
    """
    reach = cloud.radius + CONTACT * cloud.radius
    n_nodes = tree_nodes.write_cloud(cloud.points, T[:3].ravel(), reach, row, arena.nodes, arena.n_nodes)
    return _tree_at_end(arena, n_nodes, -(-len(cloud.points) // WIDTH**2))


def _tree_at_end(arena: Arena, n_nodes: int, n_lowest: int) -> ObjectTree:
    """The tree of the ``n_nodes`` nodes just written to the end of an arena.

    ``n_lowest`` of them form its lowest level of AABBs.
    """
    arena.n_nodes += n_nodes
    n_levels = 1
    while n_lowest > 1:
        n_levels, n_lowest = n_levels + 1, -(-n_lowest // WIDTH)
    sides = arena.nodes[NODE_ROWS * (arena.n_nodes - 1) : NODE_ROWS * arena.n_nodes]
    return ObjectTree(PLACES * (arena.n_nodes - 1), n_levels, sides[:3].min(axis=1), sides[3:CHILD].max(axis=1))


def remove_child(arena: Arena, tree: ObjectTree, place: int) -> ObjectTree:
    """Remove the child at a place, counted in the order of writing.

    The nodes on the path from the root to its leaf are copied to new nodes.
    """
    node, root, last = tree.root // PLACES, arena.n_nodes, tree.n_levels - 1
    for level in range(tree.n_levels):
        lane, first = place >> 3 * (last - level) & WIDTH - 1, NODE_ROWS * arena.n_nodes
        arena.nodes[first : first + NODE_ROWS] = arena.nodes[NODE_ROWS * node : NODE_ROWS * (node + 1)]
        arena.n_nodes += 1
        if level == last:
            column = arena.nodes[first : first + NODE_ROWS, lane]
            column[:3], column[3:CHILD], column[CHILD] = NOWHERE, -NOWHERE, np.nan
        else:
            node = int(arena.nodes[first + CHILD, lane]) // PLACES
            arena.nodes[first + CHILD, lane] = PLACES * arena.n_nodes
    return tree._replace(root=PLACES * root)
