"""Finds the nodes of the BVH that a body can reach in any of eight intervals of an edge.

The children of a node are tested twice. First all eight at once, a lane each, against one AABB round the body in all intervals.
Then each that is left against the body in all eight intervals at once, a lane each: the distance of the body's bounding ball,
and of the box round its core, from the child's AABB is compared with how far the body gets, ``within`` [m]. A child that is
farther in every interval is clear as a whole. So the time of a search depends on what is near, not on how many objects there are.

The bound for the box round the core is the gap of two boxes along the body's axes: in the body's frame the child's AABB, with
half extents h, lies within a box of half extents |R|^T h about the same middle.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, lane_count, lane_of, lowest_bit
from ulna.kernels.collision.bvh import child_of, child_rows, children_in
from ulna.kernels.collision.posed_pair import BALLS
from ulna.kernels.collision.rounded_core import beyond, core_radius
from ulna.kernels.layout import HALF_EXTENTS, REACH, SHAPE, SPHERE
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.vectors import dot, transform_inverse

NEVER = -1.0  # as ``within`` of a lane: nothing in it is looked for


@kernel
def tree_is_reached(nodes, root, p, within, radius, stack):
    """Whether a ball with its centre p and a radius reaches the AABB of any solid in a tree."""
    bounds, top = ball_bounds(p, within + radius), 1
    stack[0] = root
    while top > 0:
        top -= 1
        node = stack[top]
        if node < 0:
            return True
        bits = children_in(nodes, node, bounds)
        while bits != 0:
            lane = lowest_bit(bits)
            if any_lane(ball_reaches(*child_box(nodes, node, lane), p, within, radius)):
                stack[top] = child_of(nodes, node, lane)
                top += 1
            bits &= bits - 1
    return False


@kernel
def push_reached(nodes, node, bounds, bodies, k, a, p, within, stack, top):
    """Push those children of a node that body k, at pose a with its centre p, reaches onto a stack; return the new top.

    bounds: ``ball_bounds`` of the body.
    """
    bits = children_in(nodes, node, bounds)
    while bits != 0:
        lane = lowest_bit(bits)
        centre, half = child_box(nodes, node, lane)
        reaches = ball_reaches(centre, half, p, within, BALLS * bodies[k, REACH])
        if any_lane(reaches) and int(bodies[k, SHAPE]) != SPHERE:
            reaches = reaches & core_reaches(centre, half, bodies, k, a, within)
        if any_lane(reaches):
            stack[top] = child_of(nodes, node, lane)
            top += 1
        bits &= bits - 1
    return top


@kernel
def child_box(nodes, node, lane):
    """The middle and the half extents of a child's AABB, in plain numbers."""
    i, last, reach = child_rows(nodes, node)
    low = nodes[i, lane], nodes[i + 1, lane], nodes[i + 2, lane]
    high = nodes[last, lane], nodes[last + 1, lane], nodes[last + 2, lane]
    centre = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    return centre, (0.5 * (high[0] - low[0]) + reach, 0.5 * (high[1] - low[1]) + reach, 0.5 * (high[2] - low[2]) + reach)


@kernel
def ball_reaches(centre, half, p, within, radius):
    """True where the surface of a ball with its centre p is no farther than ``within`` from an AABB."""
    most = within + radius
    e = beyond(p[0] - centre[0], half[0]), beyond(p[1] - centre[1], half[1]), beyond(p[2] - centre[2], half[2])
    return (dot(e, e) <= most * most) & (within >= 0.0)


@kernel
def core_reaches(centre, half, bodies, k, a, within):
    """True where the rounded box of body k, at pose a, is no farther than ``within`` from an AABB, by the bound given above."""
    x, most, c = transform_inverse(a, centre), within + core_radius(bodies, k), HALF_EXTENTS
    e = (
        maximum(abs(x[0]) - (bodies[k, c] + turned_half(a, 0, half)), 0.0),
        maximum(abs(x[1]) - (bodies[k, c + 1] + turned_half(a, 1, half)), 0.0),
        maximum(abs(x[2]) - (bodies[k, c + 2] + turned_half(a, 2, half)), 0.0),
    )
    return dot(e, e) <= most * most


@kernel
def turned_half(a, axis, half):
    """Half the extent of an AABB along an axis of pose a."""
    return abs(a[axis]) * half[0] + abs(a[4 + axis]) * half[1] + abs(a[8 + axis]) * half[2]


@kernel
def ball_bounds(p, radius):
    """One AABB, in plain numbers, round a ball in all lanes."""
    return (
        (least(p[0] - radius), least(p[1] - radius), least(p[2] - radius)),
        (-least(-p[0] - radius), -least(-p[1] - radius), -least(-p[2] - radius)),
    )


@kernel
def least(x):
    """The least of the lanes."""
    lowest = lane_of(x, 0)
    for lane in range(1, lane_count(x)):
        lowest = min(lowest, lane_of(x, lane))
    return lowest
