"""Computes the AABB of a body and searches a BVH of a world's objects.

The tree is complete: eight children a node, node 0 the root, node i above nodes 8 i + 1 to 8 i + 8, and under the nodes of the
last level the objects, eight a node, in the order of their table. So it needs no pointers: a node is six rows of eight numbers,
the least x, y, z of each child and the greatest, and one node is tested in one go, a child a lane. A missing
child has an empty AABB: its least values are above all others, its greatest below.

Source: Omohundro, Five balltree construction algorithms (1989), for the idea of a static tree over bounds; the order of the
objects is that of ``collision.objects``.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import WIDTH, lane_bits, lane_of, load, lowest_bit, sqrt, store, where
from ulna.kernels.collision.posed_pair import half_extents
from ulna.kernels.layout import CONTACT, RADIUS
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.se3 import load_pose

DEPTH = 11  # levels of a tree over 8^11 objects, more than memory holds
STACK = 8 * (DEPTH + 1)


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
    """Write the bounds of every body of the robot to bound_rows, six rows each."""
    for k in range(bodies.shape[0]):
        low, high = bounds_of(bodies, k, load_pose(body_rows, k))
        for i in range(3):
            store(bound_rows, 6 * k + i, low[i])
            store(bound_rows, 6 * k + 3 + i, high[i])


@kernel
def lane_bounds(rows, k, lane):
    """Bounds k of rows in one lane, in plain numbers."""
    i = 6 * k
    return (rows[i, lane], rows[i + 1, lane], rows[i + 2, lane]), (rows[i + 3, lane], rows[i + 4, lane], rows[i + 5, lane])


@kernel
def first_leaf(n):
    """The number of the first node of the last level of a tree over n objects."""
    first, width, n_leaves = 0, 1, (n + WIDTH - 1) // WIDTH
    while width < n_leaves:
        first += width
        width *= WIDTH
    return first


@kernel
def child_gap(nodes, node, bounds):
    """The gap between the AABB of each child and the given one, axis by axis: negative where they overlap."""
    i, (low, high) = 6 * node, bounds
    return (
        maximum(load(nodes, i) - high[0], low[0] - load(nodes, i + 3)),
        maximum(load(nodes, i + 1) - high[1], low[1] - load(nodes, i + 4)),
        maximum(load(nodes, i + 2) - high[2], low[2] - load(nodes, i + 5)),
    )


@kernel
def children_in(nodes, node, bounds):
    """The children of a node whose AABBs overlap the given one, as bits."""
    x, y, z = child_gap(nodes, node, bounds)
    return lane_bits(maximum(maximum(x, y), z) <= 0.0)


@kernel
def gap_bound(gap):
    """A lower bound of the signed distance of two bodies whose AABBs have these gaps, axis by axis."""
    x, y, z = gap
    widest = maximum(maximum(x, y), z)
    x, y, z = maximum(x, 0.0), maximum(y, 0.0), maximum(z, 0.0)
    return where(widest > 0.0, sqrt(x * x + y * y + z * z), widest)


@kernel
def push_children(nodes, node, bounds, within, stack, heights, top):
    """Push those children of a node that are nearer than ``within`` [m] onto a stack, the nearest on top; return the new top.

    ``heights`` is a second stack, of the lower bounds of their distances. The objects below the last level are numbered as if
    they were the nodes of one more level.
    """
    height = gap_bound(child_gap(nodes, node, bounds))
    bits, bottom = lane_bits(height < within), top
    while bits != 0:
        lane = lowest_bit(bits)
        x, i = lane_of(height, lane), top
        while i > bottom and heights[i - 1] < x:
            stack[i], heights[i] = stack[i - 1], heights[i - 1]
            i -= 1
        stack[i], heights[i] = WIDTH * node + 1 + lane, x
        top += 1
        bits &= bits - 1
    return top


@kernel
def objects_within(nodes, n, bounds, stack, found):
    """Write to found the indices of the objects, of n in a tree, whose AABBs overlap the given one; return how many."""
    leaf, top, count = first_leaf(n), 1, 0
    stack[0] = 0
    while top > 0:
        top -= 1
        node = stack[top]
        bits = children_in(nodes, node, bounds)
        while bits != 0:
            child = WIDTH * node + lowest_bit(bits)
            if node >= leaf:
                found[count] = child - WIDTH * leaf
                count += 1
            else:
                stack[top] = child + 1
                top += 1
            bits &= bits - 1
    return count
