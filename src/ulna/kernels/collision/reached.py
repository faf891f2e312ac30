"""Measures a point's distance from a body's core, and finds the nodes of the BVH within a body's reach.

A body is a core swept by a ball of RADIUS (``kernels.layout``). For a sphere, a capsule and a box, the smallest box that holds
the core is the core itself. Then the distance from this box, less the radius, is the body's distance. Otherwise it is a lower
bound.

The children of a node are tested twice. The first test takes all eight children at once, a lane each. It compares them with one
AABB that contains the body in all eight intervals. The second test takes each remaining child against the body in all eight
intervals at once, a lane each. It measures two distances from the child's AABB: the distance of the body's bounding ball, and of
the box round the body's core. Both are compared with a bound on the body's motion, ``within`` [m]. A child that is farther away
in every interval is clear as a whole. So the time of a search depends on nearby objects, not on the number of objects.

The bound for the box round the core is the gap of two boxes along the body's axes. In the body's frame, a child's AABB with half
extents h lies within a box of half extents |R|^T h about the same center.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, lane_count, lane_of, lowest_bit, splat
from ulna.kernels.collision.ball_motion import component_along
from ulna.kernels.collision.bounding_planes import beyond_planes
from ulna.kernels.collision.bvh import child_of, child_rows, children_in, half_in_body_frame
from ulna.kernels.collision.posed_pair import BALLS
from ulna.kernels.layout import BOX, HALF_EXTENTS, HALF_SPACE, RADIUS, REACH, SHAPE, SPHERE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import dot, minus, origin, rotate_inverse, transform_inverse

NEVER = -1.0  # as ``within`` of a lane: no pair is near enough


@kernel
def core_offset(p, bodies, j, b):
    """The vector from the box around the core of body j, at pose b, to a point [m]; 0 inside.

    It is in the body's frame. A sphere's core is its center; its vector is in the frame of p. A half-space is its own core.
    """
    if int(bodies[j, SHAPE]) == SPHERE:
        return minus(p, origin(b))
    x = transform_inverse(b, p)
    if int(bodies[j, SHAPE]) == HALF_SPACE:
        none = splat(0.0, x[2])
        return none, none, maximum(x[2], 0.0)
    c = HALF_EXTENTS
    return excess(x[0], bodies[j, c]), excess(x[1], bodies[j, c + 1]), excess(x[2], bodies[j, c + 2])


@kernel
def core_slope(e, v, bodies, j, b):
    """The rate of change of the length of ``core_offset``, e, at velocity v; 0 where e is 0."""
    return component_along(e, v if int(bodies[j, SHAPE]) == SPHERE else rotate_inverse(b, v))


@kernel
def core_radius(bodies, j):
    """The radius of body j round its core [m]; points farther from the core are outside the body."""
    return 0.0 if int(bodies[j, SHAPE]) == HALF_SPACE else bodies[j, RADIUS]


@kernel
def excess(x, extent):
    """The signed excess of x beyond [-extent, extent]; 0 inside."""
    return x - minimum(maximum(x, -extent), extent)


@kernel
def has_exact_ball(kind, other):
    """Whether the bounding ball's distance from the box round the other core is the exact distance of the bodies."""
    return kind == SPHERE and (other <= BOX or other == HALF_SPACE)


@kernel
def tree_is_reached(scene, root, p, within, radius, stack):
    """Whether a ball with center p and a radius reaches the AABB of any solid in a tree."""
    bounds, top = ball_bounds(p, within + radius), 1
    stack[0] = root
    while top > 0:
        top -= 1
        node = stack[top]
        if node < 0:
            return True
        bits = children_in(scene, node, bounds)
        while bits != 0:
            lane = lowest_bit(bits)
            if any_lane(ball_reaches(*child_box(scene, node, lane), p, within, radius)):
                stack[top] = child_of(scene, node, lane)
                top += 1
            bits &= bits - 1
    return False


@kernel
def push_reached(scene, node, body, within, margins, stack, top):
    """Push the children of a node that a body reaches onto a stack; return the new top.

    body: A ``scene.Posed``, its center, and its ``ball_bounds``. margins: None, or margins whose planes give further bounds.
    """
    posed, p, bounds = body
    bodies, k, bits = posed.table, posed.row, children_in(scene, node, bounds)
    while bits != 0:
        lane = lowest_bit(bits)
        center, half = child_box(scene, node, lane)
        reaches = ball_reaches(center, half, p, within, BALLS * bodies[k, REACH])
        if any_lane(reaches) and int(bodies[k, SHAPE]) != SPHERE:
            reaches = reaches & core_reaches(center, half, bodies, k, posed.pose, within)
            if margins is not None:
                x = transform_inverse(posed.pose, center)
                reaches = reaches & (beyond_planes(margins.planes, k, posed.pose, x, half) <= within)
        if any_lane(reaches):
            stack[top] = child_of(scene, node, lane)
            top += 1
        bits &= bits - 1
    return top


@kernel
def child_box(scene, node, lane):
    """The center and the half extents of a child's AABB, in plain numbers."""
    nodes, (i, last, reach) = scene.nodes, child_rows(scene, node)
    low = nodes[i, lane], nodes[i + 1, lane], nodes[i + 2, lane]
    high = nodes[last, lane], nodes[last + 1, lane], nodes[last + 2, lane]
    center = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    return center, (0.5 * (high[0] - low[0]) + reach, 0.5 * (high[1] - low[1]) + reach, 0.5 * (high[2] - low[2]) + reach)


@kernel
def ball_reaches(center, half, p, within, radius):
    """True where the surface of a ball with center p is at most ``within`` from an AABB."""
    limit = within + radius
    e = excess(p[0] - center[0], half[0]), excess(p[1] - center[1], half[1]), excess(p[2] - center[2], half[2])
    return (dot(e, e) <= limit * limit) & (within >= 0.0)


@kernel
def core_reaches(center, half, bodies, k, a, within):
    """True where the rounded box of body k, at pose a, may be at most ``within`` from an AABB.

    The lower bound of their distance is the gap given in the module's docstring.
    """
    x, limit, c = transform_inverse(a, center), within + core_radius(bodies, k), HALF_EXTENTS
    e = (
        maximum(abs(x[0]) - (bodies[k, c] + half_in_body_frame(a, 0, half)), 0.0),
        maximum(abs(x[1]) - (bodies[k, c + 1] + half_in_body_frame(a, 1, half)), 0.0),
        maximum(abs(x[2]) - (bodies[k, c + 2] + half_in_body_frame(a, 2, half)), 0.0),
    )
    return dot(e, e) <= limit * limit


@kernel
def ball_bounds(p, radius):
    """The AABB, in plain numbers, of a ball's positions in all lanes."""
    return (
        (lane_minimum(p[0] - radius), lane_minimum(p[1] - radius), lane_minimum(p[2] - radius)),
        (-lane_minimum(-p[0] - radius), -lane_minimum(-p[1] - radius), -lane_minimum(-p[2] - radius)),
    )


@kernel
def lane_minimum(x):
    """The minimum over the lanes."""
    lowest = lane_of(x, 0)
    for lane in range(1, lane_count(x)):
        lowest = min(lowest, lane_of(x, lane))
    return lowest
