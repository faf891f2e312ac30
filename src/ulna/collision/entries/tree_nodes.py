"""Writes the nodes of trees (``kernels.collision.bvh``) over solids and over the points of clouds.

The children of a node are eight consecutive ones in the given order. Levels are written from the leaves up, so only the last node
of a level may be incomplete. The root is the last node. A tree has at least one node, even over a single child.
"""

import numpy as np

from ulna.collision.entries.morton_order import NUMBER, sorted_keys
from ulna.engine.decorators import entry, kernel, routine
from ulna.engine.lanes import WIDTH, empty_rows, load, load_columns, splat, store
from ulna.engine.signatures import MATRIX, NUMBERS, POINTS, POINTS_32, WHOLE
from ulna.engine.signatures import NUMBER as PLAIN
from ulna.kernels.collision.collision_layout import BALL_REACH, BALL_ROW, CHILD, FIRST_POINTS, NODE_ROWS, NOWHERE, PLACES
from ulna.kernels.spatial.elementary import maximum, minimum


@entry((MATRIX, MATRIX, NUMBERS, MATRIX, WHOLE))
def write_tree(low, high, children, nodes, first):
    """Write a tree over bounds in the given order, shape (n, 3) each, n > 0; its number of nodes.

    children: The child within each bound, as a node encodes it, shape (n,). first: The number of the first node to write.
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
    """Write a tree over balls about points, shape (n, 3), n > 0; the number of its nodes.

    T: The upper three rows of T_base_cloud, shape (12,). reach: The radius of a ball, with the margin for contacts [m]. row: The
    row of the ball in the table of solids. first: The number of the first node to write.
    """
    keys, n, rows = sorted_keys(points), points.shape[0], empty_rows(3 * WIDTH)
    n_leaves = (n + WIDTH - 1) // WIDTH
    n_lowest, above = (n_leaves + WIDTH - 1) // WIDTH, first + (n_leaves + 1) // 2
    for i in range(n_lowest):
        gather_points(points, keys, WIDTH * WIDTH * i, rows)
        write_leaves(rows, T, (row, reach), nodes, first + i * WIDTH // 2, above + i, min(WIDTH, n_leaves - WIDTH * i))
    for k in range(n, 2 * WIDTH * (above - first)):
        i, lane = NODE_ROWS * (first + k // (2 * WIDTH)) + 3 * (k // WIDTH % 2), k % WIDTH
        nodes[i, lane], nodes[i + 1, lane], nodes[i + 2, lane] = NOWHERE, NOWHERE, NOWHERE
    clear_rest(nodes, above, n_leaves)
    return write_levels(nodes, above, n_lowest) + 1 - first


@routine
def gather_points(points, keys, start, rows):
    """Copy 64 points to rows, eight of x, of y and of z. The last point fills missing ones."""
    last = points.shape[0] - 1
    for i in range(WIDTH):
        for lane in range(WIDTH):
            k = keys[min(start + WIDTH * i + lane, last)] & NUMBER
            rows[i, lane], rows[WIDTH + i, lane], rows[2 * WIDTH + i, lane] = points[k, 0], points[k, 1], points[k, 2]


@routine
def write_leaves(rows, T, ball, nodes, first, above, n):
    """Write n times eight points, n at most 8, to nodes, and their bounds to the node above.

    A node holds sixteen points. first: The number of the first node of points. ball: The ball's row in the table of solids, and
    its radius; as in ``write_cloud``.
    """
    (row, reach), like = ball, load(rows, 0)
    for leaf in range(WIDTH):
        x, y, z = load(rows, leaf), load(rows, WIDTH + leaf), load(rows, 2 * WIDTH + leaf)
        number = first + leaf // 2
        for axis in range(3):
            placed = T[4 * axis] * x + T[4 * axis + 1] * y + T[4 * axis + 2] * z + T[4 * axis + 3]
            store(rows, WIDTH * axis + leaf, placed)
            if leaf < n:
                store(nodes, NODE_ROWS * number + 3 * (leaf % 2) + axis, placed)
        nodes[NODE_ROWS * above + CHILD, leaf] = float(PLACES * number + FIRST_POINTS + leaf % 2)
        if leaf < n and leaf % 2 == 0:
            store(nodes, NODE_ROWS * number + CHILD, splat(0.0, like))
            nodes[NODE_ROWS * number + CHILD, BALL_ROW], nodes[NODE_ROWS * number + CHILD, BALL_REACH] = float(row), reach
    for axis in range(3):
        a, b, c, d, e, f, g, h = load_columns(rows, WIDTH * axis, 0)
        low = minimum(minimum(minimum(a, b), minimum(c, d)), minimum(minimum(e, f), minimum(g, h)))
        high = maximum(maximum(maximum(a, b), maximum(c, d)), maximum(maximum(e, f), maximum(g, h)))
        store(nodes, NODE_ROWS * above + axis, low - reach)
        store(nodes, NODE_ROWS * above + 3 + axis, high + reach)


@routine
def write_levels(nodes, first, n):
    """Write the levels above n nodes, which begin at number ``first``, up to a root; its number."""
    while n > 1:
        above = first + n
        for k in range(n):
            write_lane_above(nodes, first + k, NODE_ROWS * (above + k // WIDTH), k % WIDTH)
        clear_rest(nodes, above, n)
        first, n = above, (n + WIDTH - 1) // WIDTH
    return first


@kernel
def write_lane_above(nodes, number, i, lane):
    """Write the AABB and the number of a node to a lane of its parent, whose first row is i."""
    source = NODE_ROWS * number
    for axis in range(3):
        low, high = nodes[source + axis, 0], nodes[source + 3 + axis, 0]
        for child in range(1, WIDTH):
            low, high = min(low, nodes[source + axis, child]), max(high, nodes[source + 3 + axis, child])
        nodes[i + axis, lane], nodes[i + 3 + axis, lane] = low, high
    nodes[i + CHILD, lane] = float(PLACES * number)


@routine
def clear_rest(nodes, first, n):
    """Mark the missing children in the last node of a level with n children; ``first`` is its first node."""
    for k in range(n, WIDTH * ((n + WIDTH - 1) // WIDTH)):
        clear_lane(nodes, NODE_ROWS * (first + k // WIDTH), k % WIDTH)


@kernel
def clear_lane(nodes, i, lane):
    """Write that a node of AABBs has no child in a lane. i: its first row."""
    for axis in range(3):
        nodes[i + axis, lane], nodes[i + 3 + axis, lane] = NOWHERE, -NOWHERE
    nodes[i + CHILD, lane] = np.nan
