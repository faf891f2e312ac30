"""Decides of eight intervals of an edge which are free. Used by ``drivers.free_edge``.

An interval has one of three outcomes, each from one distance at its middle, d, and a bound on the motion in it, ``reach``:

- d <= margin: something touches, so the edge is not free, and no more of it need be looked at;
- d > reach + margin: the pair is clear in all of the interval;
- between: unknown, and the interval is split.

Balls first: the ball that holds all bodies of a joint is compared with the box that holds an object, the balls of two joints
with each other. Only where these are near are bodies placed and compared, by their own bounding balls first. Of a ball, only the
motion of its centre towards the box counts (``ball_motion``). For a sphere and a sphere, capsule, box or half-space that is their
distance. For other shapes a lower bound of the distance is computed
(``posed_pair.rows_gap``), only as far as it takes to know that it is not above ``reach``; where it says "touches" it is computed
once more, as far as it takes for that. So "clear" is certain; "touches" is certain but for the resolution of that bound.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import any_lane, load, splat, sqrt, where
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.collision.ball_motion import (
    along,
    approach_way,
    body_velocity,
    body_way,
    centre_way,
    joint_twist,
    load_vector,
    pair_way,
    place_bodies_of,
    turning_at,
)
from ulna.kernels.collision.bvh import objects_within
from ulna.kernels.collision.collision_layout import (
    BALL_JOINT,
    BALL_RADIUS,
    GROUP_A,
    GROUP_B,
    GROUP_END,
    GROUP_FIRST,
    GROUP_SHARED,
    RUN_BODY,
    RUN_END,
    RUN_FIRST,
)
from ulna.kernels.collision.continuous import CROWD, span_of
from ulna.kernels.collision.posed_pair import BALLS, rows_gap
from ulna.kernels.layout import BOX, HALF_EXTENTS, HALF_SPACE, JOINT, RADIUS, REACH, SHAPE, SPHERE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import constant_pose
from ulna.kernels.spatial.vectors import dot, minus, origin, rotate_inverse, transform_inverse


@kernel
def world_outcome(scene, carried, half, still, margin, of_world, finest, stack, found, like):
    """Whether a body touches an object in any lane; and 1.0 in the lanes in whose interval all of them are clear, else 0.0.

    still: whether ``half`` is 0; margin: how near an object may be [m]; of_world: how far rounding may put a point of an
    object [m]. The last balls first: a hand touches something more often than a base.
    """
    clear, bodies, balls, n = splat(1.0, like), scene.bodies, carried.balls, scene.joints.shape[0]
    for back in range(balls.shape[0]):
        g = balls.shape[0] - 1 - back
        joint, slack = int(balls[g, BALL_JOINT]), carried.slacks[g] + of_world + margin
        p, reach = load_vector(carried.ball_rows, 7 * g), load(carried.ball_rows, 7 * g + 6) + slack
        n_near = objects_near(scene, carried, g, p, reach, half, still, slack, finest, stack, found)
        if n_near < 0:
            return False, splat(0.0, like)
        if n_near == 0:
            continue
        place_bodies_of(bodies, carried, g, like)
        turning = turning_at(carried, joint, still, like)
        for m in range(carried.first[g], carried.first[g + 1]):
            k = carried.order[m]
            p, v = load_vector(carried.centre_rows, 3 * k), body_velocity(carried, g, k, still, like)
            way = body_way(carried, g, n, v, turning * bodies[k, REACH], half, still) + slack
            for i in range(n_near):
                o = carried.near[i]
                if o < scene.n_unindexed and carried.may_touch[k, o]:
                    continue
                touches, clear = body_outcome(scene, carried, g, k, o, p, v, way, slack, half, still, margin, clear)
                if touches:
                    return True, clear
    return False, clear


@kernel
def body_outcome(scene, carried, g, k, o, p, v, way, slack, half, still, margin, clear):
    """The same for body k, of ball g, and object o.

    p, v: the body's centre and its velocity; way: how far a point of it gets within ``half``, and ``slack``.
    """
    bodies, objects, n, b = scene.bodies, scene.objects, scene.joints.shape[0], constant_pose(scene.objects, o, half)
    e, radius, nearer = core_offset(p, objects, o, b), core_radius(objects, o) + BALLS * bodies[k, REACH], way
    most = way + radius
    if not any_lane((dot(e, e) <= most * most) & (clear > 0.0)):
        return False, clear
    distance = sqrt(dot(e, e)) - radius
    if not still:
        nearer = minimum(way, centre_way(carried, g, n, core_slope(e, v, objects, o, b), half) + slack)
        if not any_lane((distance <= nearer) & (clear > 0.0)):
            return False, clear
    away = distance > nearer
    if not has_exact_ball(int(bodies[k, SHAPE]), int(objects[o, SHAPE])):
        a = frame_pose(bodies, k, carried.joint_rows, half)
        ours, theirs = (bodies, scene.vertices, k, a), (objects, scene.points, o, b)
        distance = gap_or_contact(ours, theirs, way, margin, slack - margin)
        away = away | (distance > way)
    return any_lane(distance <= margin), where(away, clear, 0.0)


@kernel
def objects_near(scene, carried, g, p, reach, half, still, slack, finest, stack, found):
    """Write to ``near`` the objects that a ball with its centre p may reach in any lane; how many, or -1 of a crowd.

    reach: how far a point of it gets within ``half``, and ``slack``.
    """
    balls, objects, n = carried.balls, scene.objects, 0
    radius = BALLS * balls[g, BALL_RADIUS]
    for o in range(scene.n_unindexed):
        d, most = minus(p, (objects[o, 3], objects[o, 7], objects[o, 11])), reach + (radius + BALLS * objects[o, REACH])
        if any_lane(dot(d, d) <= most * most) and is_near(scene, carried, g, p, o, reach, half, still, slack):
            carried.near[n] = o
            n += 1
    n_indexed = objects.shape[0] - scene.n_unindexed
    if n_indexed > 0:
        widest = radius + span_of(reach)[1]
        (x, u), (y, v), (z, w) = span_of(p[0]), span_of(p[1]), span_of(p[2])
        bounds = (x - widest, y - widest, z - widest), (u + widest, v + widest, w + widest)
        n_found = objects_within(scene.nodes, n_indexed, bounds, stack, found)
        if n_found > CROWD and not finest:
            return -1
        for i in range(n_found):
            o = scene.n_unindexed + found[i]
            if is_near(scene, carried, g, p, o, reach, half, still, slack):
                carried.near[n] = o
                n += 1
    return n


@kernel
def is_near(scene, carried, g, p, o, reach, half, still, slack):
    """Whether a ball with its centre p may reach object o in any lane."""
    b, radius, n = constant_pose(scene.objects, o, p[0]), BALLS * carried.balls[g, BALL_RADIUS], scene.joints.shape[0]
    e, radius = core_offset(p, scene.objects, o, b), core_radius(scene.objects, o) + radius
    most = reach + radius
    near = any_lane(dot(e, e) <= most * most)
    if still or not near:
        return near
    slope = core_slope(e, load_vector(carried.ball_rows, 7 * g + 3), scene.objects, o, b)
    most = centre_way(carried, g, n, slope, half) + (slack + radius)
    return any_lane(dot(e, e) <= most * most)


@kernel
def self_outcome(scene, carried, half, still, clear, like):
    """The same as ``world_outcome`` for the pairs of the robot's own bodies; lanes that are not clear stay so."""
    bodies, balls, groups = scene.bodies, carried.balls, carried.groups
    for e in range(groups.shape[0]):
        a, b = groups[e, GROUP_A], groups[e, GROUP_B]
        d = minus(load_vector(carried.ball_rows, 7 * a), load_vector(carried.ball_rows, 7 * b))
        slack, radii = carried.slacks[a] + carried.slacks[b], BALLS * (balls[a, BALL_RADIUS] + balls[b, BALL_RADIUS])
        most = radii + slack + load(carried.ball_rows, 7 * a + 6) + load(carried.ball_rows, 7 * b + 6)
        if not any_lane(dot(d, d) <= most * most):
            continue
        way, shared = splat(slack, like), groups[e, GROUP_SHARED]
        if not still:
            v = minus(load_vector(carried.ball_rows, 7 * a + 3), load_vector(carried.ball_rows, 7 * b + 3))
            most = radii + (approach_way(scene.joints, carried, a, b, shared, d, v, half) + slack)
            if not any_lane(dot(d, d) <= most * most):
                continue
            way = pair_way(scene.joints, carried, a, b, shared, half, like) + slack
        place_bodies_of(bodies, carried, a, like)
        place_bodies_of(bodies, carried, b, like)
        for run in range(groups[e, GROUP_FIRST], groups[e, GROUP_END]):
            i = carried.runs[run, RUN_BODY]
            p = load_vector(carried.centre_rows, 3 * i)
            d = minus(p, load_vector(carried.ball_rows, 7 * b))
            most = way + BALLS * (bodies[i, REACH] + balls[b, BALL_RADIUS])
            if not any_lane((dot(d, d) <= most * most) & (clear > 0.0)):
                continue
            for m in range(carried.runs[run, RUN_FIRST], carried.runs[run, RUN_END]):
                touches, clear = pair_outcome(scene, carried, e, i, carried.others[m], p, way, slack, half, still, clear)
                if touches:
                    return True, clear
    return False, clear


@kernel
def pair_outcome(scene, carried, e, i, j, p, way, slack, half, still, clear):
    """The same for bodies i and j, of the two balls of group e. p: the centre of body i; way, slack: as in ``self_outcome``."""
    bodies, q = scene.bodies, load_vector(carried.centre_rows, 3 * j)
    d, reach = minus(p, q), BALLS * (bodies[i, REACH] + bodies[j, REACH])
    most = way + reach
    if not any_lane((dot(d, d) <= most * most) & (clear > 0.0)):
        return False, clear
    distance, nearer = sqrt(dot(d, d)) - reach, way
    if int(bodies[i, SHAPE]) != SPHERE or int(bodies[j, SHAPE]) != SPHERE:
        of_j = frame_pose(bodies, j, carried.joint_rows, half)
        e, most = core_offset(p, bodies, j, of_j), way + (core_radius(bodies, j) + BALLS * bodies[i, REACH])
        if not any_lane((dot(e, e) <= most * most) & (clear > 0.0)):
            return False, clear
        of_i = frame_pose(bodies, i, carried.joint_rows, half)
        ours, theirs = (bodies, scene.vertices, i, of_i), (bodies, scene.vertices, j, of_j)
        distance = gap_or_contact(ours, theirs, way, 0.0, slack)
    else:
        nearer = minimum(way, spheres_way(scene, carried, e, (i, j), (p, q), half, still) + slack)
    return any_lane(distance <= 0.0), where(distance > nearer, clear, 0.0)


@kernel
def spheres_way(scene, carried, e, pair, centres, half, still):
    """How much nearer two spheres of group e with these centres come within ``half``. A turn about its own centre moves none."""
    if still:
        return splat(0.0, half)
    groups, (i, j), (p, q) = carried.groups, pair, centres
    v_p = joint_twist(carried, int(scene.bodies[i, JOINT]), p, half)[0]
    v_q = joint_twist(carried, int(scene.bodies[j, JOINT]), q, half)[0]
    a, b, shared = groups[e, GROUP_A], groups[e, GROUP_B], groups[e, GROUP_SHARED]
    return approach_way(scene.joints, carried, a, b, shared, minus(p, q), minus(v_p, v_q), half)


@kernel
def gap_or_contact(first, second, reach, margin, rounding):
    """A lower bound of the distance of two bodies, exact enough to know whether it is above ``reach``, and above a margin.

    Each body: its table, the vertices, its row and its pose.
    """
    distance = posed_gap(*first, *second, reach, rounding)
    if any_lane(distance <= margin):
        again = posed_gap(*first, *second, splat(margin, reach), rounding)
        distance = where(distance <= margin, again, distance)
    return distance


@routine
def posed_gap(bodies, vertices, k, a, others, points, j, b, reach, rounding):
    """``posed_pair.rows_gap``, called and not inlined: it takes longest to compile."""
    return rows_gap(bodies, vertices, k, a, others, points, j, b, reach, rounding)


@kernel
def core_offset(p, others, j, b):
    """From the smallest box that holds the core of body j, at pose b, to a point, as the body's frame sees it; 0 within [m].

    A sphere's core is its centre; it is seen from the frame of p. That of a half-space is the half-space.
    """
    if int(others[j, SHAPE]) == SPHERE:
        return minus(p, origin(b))
    x = transform_inverse(b, p)
    if int(others[j, SHAPE]) == HALF_SPACE:
        none = splat(0.0, x[2])
        return none, none, maximum(x[2], 0.0)
    c = HALF_EXTENTS
    return beyond(x[0], others[j, c]), beyond(x[1], others[j, c + 1]), beyond(x[2], others[j, c + 2])


@kernel
def core_slope(e, v, others, j, b):
    """How fast the length of ``core_offset``, e, changes where the point has the velocity v; 0 where it is 0."""
    return along(e, v if int(others[j, SHAPE]) == SPHERE else rotate_inverse(b, v))


@kernel
def core_radius(others, j):
    """How far body j is round its core [m]: a point at least so far from the core is outside of it."""
    return 0.0 if int(others[j, SHAPE]) == HALF_SPACE else others[j, RADIUS]


@kernel
def beyond(x, extent):
    """How far x is beyond -extent or extent, with its sign; 0 between."""
    return x - minimum(maximum(x, -extent), extent)


@kernel
def has_exact_ball(kind, other):
    """Whether the distance of a body's bounding ball from the box round another's core is that of the two bodies."""
    return kind == SPHERE and (other <= BOX or other == HALF_SPACE)
