"""Computes the AABB of a body, and searches a BVH of a world's solids.

A node is seven rows of eight numbers, one lane for each child: the minimum x, y, z of each child, the maximum, and the child's
code. The code is the place of a node, or -1 - w for solid w. So one test covers a whole node. A node of eight balls of one cloud
holds the x, y, z of their centers. Two such nodes share seven rows; the last row holds their common values
(``collision_layout``).

Nodes never change. A change of the tree writes new nodes from the changed leaf up to a new root. A search from the old root still
sees the old tree. A missing child has the code NaN and an AABB whose minimum is above all coordinates.

Source: Omohundro, Five balltree construction algorithms (1989), for the idea of a static tree over bounds; Driscoll, Sarnak,
Sleator and Tarjan, Making data structures persistent (1989), for copying a path. ``entries.tree_nodes`` writes the nodes.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import WIDTH, lane_bits, lane_of, load, lowest_bit, sqrt, store, where
from ulna.kernels.collision.collision_layout import (
    BALL_REACH,
    BALL_ROW,
    CHILD,
    CHILDREN,
    FIRST_BALL,
    FIRST_POINTS,
    NODE_ROWS,
    NOWHERE,
    PLACES,
)
from ulna.kernels.collision.posed_pair import half_extents
from ulna.kernels.layout import CONTACT, HALF_EXTENTS, OBJECT, RADIUS
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.se3 import load_pose

DEPTH = 24  # levels: a tree of 8^11 clouds, each of 8^11 points, more than memory holds
STACK = 8 * (DEPTH + 1)
FOUND = 64  # rows
_FULL = FOUND - WIDTH  # with more rows, the children of one more node may not fit


@kernel
def bounds_of(bodies, k, a):
    """The AABB of body k, which is no half-space, at pose a, enlarged by the contact tolerance."""
    h, radius = half_extents(bodies, k, a[0]), bodies[k, RADIUS]
    radius = radius + CONTACT * (radius + h[0] + h[1] + h[2])
    x = abs(a[0]) * h[0] + abs(a[1]) * h[1] + abs(a[2]) * h[2] + radius
    y = abs(a[4]) * h[0] + abs(a[5]) * h[1] + abs(a[6]) * h[2] + radius
    z = abs(a[8]) * h[0] + abs(a[9]) * h[1] + abs(a[10]) * h[2] + radius
    return (a[3] - x, a[7] - y, a[11] - z), (a[3] + x, a[7] + y, a[11] + z)


@kernel
def place_bounds(bodies, body_rows, bound_rows):
    """Write the AABB of every body of the robot to bound_rows, six rows each."""
    for k in range(bodies.shape[0]):
        low, high = bounds_of(bodies, k, load_pose(body_rows, k))
        for i in range(3):
            store(bound_rows, 6 * k + i, low[i])
            store(bound_rows, 6 * k + 3 + i, high[i])


@kernel
def lane_bounds(rows, k, lane):
    """The AABB of body k in one lane, as plain numbers."""
    i = 6 * k
    return (rows[i, lane], rows[i + 1, lane], rows[i + 2, lane]), (rows[i + 3, lane], rows[i + 4, lane], rows[i + 5, lane])


@kernel
def child_gap(scene, node, bounds):
    """The gaps between the AABB of each child and a given AABB, axis by axis: negative where they overlap."""
    low, high = bounds
    nodes, (i, last, reach) = scene.nodes, child_rows(scene, node)
    return (
        maximum(load(nodes, i) - (high[0] + reach), (low[0] - reach) - load(nodes, last)),
        maximum(load(nodes, i + 1) - (high[1] + reach), (low[1] - reach) - load(nodes, last + 1)),
        maximum(load(nodes, i + 2) - (high[2] + reach), (low[2] - reach) - load(nodes, last + 2)),
    )


@kernel
def child_rows(scene, node):
    """The rows where the children's minimum and maximum x, y, z begin, and a margin around them [m]."""
    i, kind = NODE_ROWS * (node // PLACES), kind_of(scene, node)
    if kind == CHILDREN:
        return i, i + 3, 0.0
    first = i + 3 * (kind - FIRST_POINTS)
    return first, first, scene.nodes[i + CHILD, BALL_REACH]


@kernel
def kind_of(scene, node):
    """CHILDREN, or which eight points a node holds; known to the compiler in a scene of boxes alone, which has no cloud."""
    return CHILDREN if scene.points is None else node % PLACES


@kernel
def children_in(scene, node, bounds):
    """The children of a node whose AABBs overlap the given one, as bits."""
    x, y, z = child_gap(scene, node, bounds)
    return lane_bits(maximum(maximum(x, y), z) <= 0.0)


@kernel
def gap_bound(gap):
    """A lower bound of the signed distance of two bodies whose AABBs have these gaps, axis by axis."""
    x, y, z = gap
    widest = maximum(maximum(x, y), z)
    x, y, z = maximum(x, 0.0), maximum(y, 0.0), maximum(z, 0.0)
    return where(widest > 0.0, sqrt(x * x + y * y + z * z), widest)


@kernel
def child_boxes(scene, node):
    """The centers and the half extents of the AABBs of a node's children, a lane each."""
    nodes, (i, last, reach) = scene.nodes, child_rows(scene, node)
    low = load(nodes, i), load(nodes, i + 1), load(nodes, i + 2)
    high = load(nodes, last), load(nodes, last + 1), load(nodes, last + 2)
    half = 0.5 * (high[0] - low[0]) + reach, 0.5 * (high[1] - low[1]) + reach, 0.5 * (high[2] - low[2]) + reach
    return (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])), half


@kernel
def gap_in_body_frame(bodies, k, a, x, half):
    """The gaps between AABBs and body k at pose a, along the body's axes: negative where they overlap.

    x: The AABBs' centers, in the body's frame. An AABB with half extents h lies within the half extents |R|^T h about the same
    center. So the bound is as good for every orientation of a body inside a large cloud. The absolute value is a maximum, since a
    GPU has no abs of eight numbers.
    """
    c, radius = HALF_EXTENTS, bodies[k, RADIUS]
    more = radius + CONTACT * (radius + bodies[k, c] + bodies[k, c + 1] + bodies[k, c + 2])
    return (
        maximum(x[0], 0.0 - x[0]) - (half_in_body_frame(a, 0, half) + (bodies[k, c] + more)),
        maximum(x[1], 0.0 - x[1]) - (half_in_body_frame(a, 1, half) + (bodies[k, c + 1] + more)),
        maximum(x[2], 0.0 - x[2]) - (half_in_body_frame(a, 2, half) + (bodies[k, c + 2] + more)),
    )


@kernel
def half_in_body_frame(a, axis, half):
    """The half extent of an AABB along an axis of pose a."""
    return abs(a[axis]) * half[0] + abs(a[4 + axis]) * half[1] + abs(a[8 + axis]) * half[2]


@kernel
def push_children(scene, node, height, within, stack, heights, top):
    """Push a node's children nearer than ``within`` [m] onto a stack, the nearest on top; return the new top.

    height: Lower bounds of the children's distances [m], a lane each. ``heights`` is the stack of these bounds.
    """
    bits, bottom = lane_bits(height < within), top
    while bits != 0:
        lane = lowest_bit(bits)
        x, i = lane_of(height, lane), top
        while i > bottom and heights[i - 1] < x:
            stack[i], heights[i] = stack[i - 1], heights[i - 1]
            i -= 1
        stack[i], heights[i] = child_of(scene, node, lane), x
        top += 1
        bits &= bits - 1
    return top


@kernel
def rows_within(scene, bounds, stack, top, found):
    """Continue a search for the solids whose AABBs overlap a given one, until it ends or ``found`` is full.

    stack: The ``top`` nodes still to search. Writes rows to found, shape (FOUND,). Returns their number and the new top, which is
    0 at the end of the search.
    """
    count = 0
    while top > 0 and count <= _FULL:
        top -= 1
        node = stack[top]
        bits = children_in(scene, node, bounds)
        while bits != 0:
            child = child_of(scene, node, lowest_bit(bits))
            if child < 0:
                found[count] = -1 - child
                count += 1
            else:
                stack[top] = child
                top += 1
            bits &= bits - 1
    return count, top


@kernel
def row_of_one_object(nodes, objects, node):
    """A row of the object that owns all solids below a node; -1 if there are several objects.

    An object is a subtree, so it owns everything between two of its solids.
    """
    row, last = end_row(nodes, node, 0), end_row(nodes, node, WIDTH - 1)
    if row < 0 or last < 0 or objects[row, OBJECT] != objects[last, OBJECT]:
        return -1
    return row


@kernel
def end_row(nodes, node, end):
    """The row of the first or last solid below a node; -1 if a node on the path is empty.

    end: The lane of that end: 0, or WIDTH - 1.
    """
    while node >= 0 and node % PLACES == CHILDREN:
        i, lane = NODE_ROWS * (node // PLACES), end
        for _ in range(WIDTH - 1):
            if nodes[i, lane] >= NOWHERE:  # a missing child
                lane += 1 if end == 0 else -1
        if nodes[i, lane] >= NOWHERE:
            return -1
        node = int(nodes[i + CHILD, lane])
    return -1 - node if node < 0 else int(nodes[NODE_ROWS * (node // PLACES) + CHILD, BALL_ROW])


@kernel
def child_of(scene, node, lane):
    """The code of a child: the place of a node, or -1 - w for solid w."""
    number, kind = node // PLACES, kind_of(scene, node)
    if kind == CHILDREN:
        return int(scene.nodes[NODE_ROWS * number + CHILD, lane])
    return -1 - (FIRST_BALL + 2 * WIDTH * number + WIDTH * (kind - FIRST_POINTS) + lane)
