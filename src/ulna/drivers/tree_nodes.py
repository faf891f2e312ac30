"""Writes the nodes of trees (``kernels.collision.bvh``), of solids and of the points of clouds.

The children of a node are eight that follow one another in the order given, level by level from the leaves up, so that all nodes
but the last of a level are full. The root is the last node. There is always one, even over a single child.
"""

import numpy as np

from ulna.drivers.morton_order import NUMBER, sorted_keys
from ulna.engine.decorators import entry, routine
from ulna.engine.lanes import WIDTH
from ulna.engine.signatures import MATRIX, NUMBERS, POINTS, POINTS_32, WHOLE
from ulna.engine.signatures import NUMBER as PLAIN
from ulna.kernels.collision.collision_layout import BALL_REACH, BALL_ROW, CHILD, FIRST_POINTS, NODE_ROWS, PLACES

_NOWHERE = 1e300  # a bound, or a coordinate, of what overlaps nothing


@entry((MATRIX, MATRIX, NUMBERS, MATRIX, WHOLE))
def write_tree(low, high, children, nodes, first):
    """Write a tree over bounds in the order given, shape (n, 3) each, n > 0, to nodes from number ``first`` on; how many nodes.

    children: what is within the bounds, as a node says it, shape (n,).
    """
    n = low.shape[0]
    for k in range(n):
        i, lane = NODE_ROWS * (first + k // WIDTH), k % WIDTH
        for axis in range(3):
            nodes[i + axis, lane], nodes[i + 3 + axis, lane] = low[k, axis], high[k, axis]
        nodes[i + CHILD, lane] = children[k]
    clear_rest(nodes, first, n)
    return write_levels(nodes, first, (n + WIDTH - 1) // WIDTH) + 1 - first


@entry(*((points, NUMBERS, PLAIN, WHOLE, MATRIX, WHOLE) for points in (POINTS, POINTS_32)))
def write_cloud(points, T, reach, row, nodes, first):
    """Write a tree over balls about points, shape (n, 3), n > 0, to nodes from number ``first`` on; how many nodes.

    T: the upper three rows of T_base_cloud, shape (12,); reach: the radius of a ball, with the margin for what touches it [m];
    row: that of the ball in the table of solids.
    """
    keys, n = sorted_keys(points), points.shape[0]
    n_leaves = (n + WIDTH - 1) // WIDTH
    above = first + (n_leaves + 1) // 2
    for leaf in range(2 * ((n_leaves + 1) // 2)):
        write_leaf(points, T, reach, row, keys, nodes, first, above, leaf)
    clear_rest(nodes, above, n_leaves)
    return write_levels(nodes, above, (n_leaves + WIDTH - 1) // WIDTH) + 1 - first


@routine
def write_leaf(points, T, reach, row, keys, nodes, first, above, leaf):
    """Write eight points, and their bounds to the node above; of a leaf past the last one nothing but places nowhere."""
    n, number = points.shape[0], first + leaf // 2
    i = NODE_ROWS * number + 3 * (leaf % 2)
    low_x, low_y, low_z, high_x, high_y, high_z = _NOWHERE, _NOWHERE, _NOWHERE, -_NOWHERE, -_NOWHERE, -_NOWHERE
    for lane in range(WIDTH):
        if WIDTH * leaf + lane < n:
            k = keys[WIDTH * leaf + lane] & NUMBER
            p, q, r = float(points[k, 0]), float(points[k, 1]), float(points[k, 2])
            x = T[0] * p + T[1] * q + T[2] * r + T[3]
            y = T[4] * p + T[5] * q + T[6] * r + T[7]
            z = T[8] * p + T[9] * q + T[10] * r + T[11]
            low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
            high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
        else:
            x, y, z = _NOWHERE, _NOWHERE, _NOWHERE
        nodes[i, lane], nodes[i + 1, lane], nodes[i + 2, lane] = x, y, z
    common = NODE_ROWS * number + CHILD
    for lane in range(WIDTH):
        nodes[common, lane] = 0.0
    nodes[common, BALL_ROW], nodes[common, BALL_REACH] = float(row), reach
    if WIDTH * leaf < n:
        i, lane = NODE_ROWS * (above + leaf // WIDTH), leaf % WIDTH
        nodes[i, lane], nodes[i + 1, lane], nodes[i + 2, lane] = low_x - reach, low_y - reach, low_z - reach
        nodes[i + 3, lane], nodes[i + 4, lane], nodes[i + 5, lane] = high_x + reach, high_y + reach, high_z + reach
        nodes[i + CHILD, lane] = float(PLACES * number + FIRST_POINTS + leaf % 2)


@routine
def write_levels(nodes, first, n):
    """Write the nodes above n nodes from number ``first`` on, up to a root; its number."""
    while n > 1:
        above = first + n
        for k in range(n):
            source, i, lane = NODE_ROWS * (first + k), NODE_ROWS * (above + k // WIDTH), k % WIDTH
            for axis in range(3):
                low, high = nodes[source + axis, 0], nodes[source + 3 + axis, 0]
                for child in range(1, WIDTH):
                    low, high = min(low, nodes[source + axis, child]), max(high, nodes[source + 3 + axis, child])
                nodes[i + axis, lane], nodes[i + 3 + axis, lane] = low, high
            nodes[i + CHILD, lane] = float(PLACES * (first + k))
        clear_rest(nodes, above, n)
        first, n = above, (n + WIDTH - 1) // WIDTH
    return first


@routine
def clear_rest(nodes, first, n):
    """Write to the last node of those from ``first`` on, which have n children, that it has no more."""
    for k in range(n, WIDTH * ((n + WIDTH - 1) // WIDTH)):
        i, lane = NODE_ROWS * (first + k // WIDTH), k % WIDTH
        for axis in range(3):
            nodes[i + axis, lane], nodes[i + 3 + axis, lane] = _NOWHERE, -_NOWHERE
        nodes[i + CHILD, lane] = np.nan
