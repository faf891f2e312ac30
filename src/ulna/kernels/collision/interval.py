"""Decides of eight intervals of an edge which are free.

An interval has one of three outcomes, each from one distance at its middle, d, and a bound on the motion in it, ``reach``:

- d <= margin: something touches, so the edge is not free, and no more of it need be looked at;
- d > reach + margin: the pair is clear in all of the interval;
- between: unknown, and the interval is split.

Balls first: the ball that holds all bodies of a joint is compared with the box that holds an object, and with the boxes of whole
nodes of the BVH (``reached``); the balls of two joints with each other. Only where these are near are bodies placed and compared,
by their own bounding balls first. Of a ball, only the motion of its center towards the box counts (``ball_motion``). For a sphere
and a sphere, capsule, box or half-space that is their distance. For other shapes a lower bound of the distance is computed
(``posed_pair.rows_gap``), only as far as it takes to know that it is not above ``reach``; where it says "touches" it is computed
once more, as far as it takes for that. So "clear" is certain; "touches" is certain but for the resolution of that bound.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import any_lane, load, splat, sqrt, where
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.collision.ball_motion import (
    approach_way,
    body_velocity,
    body_way,
    center_way,
    joint_twist,
    pair_way,
    place_bodies_of,
    turning_at,
)
from ulna.kernels.collision.bvh import row_of_one_object
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
from ulna.kernels.collision.posed_pair import (
    BALLS,
    body_at,
    is_excepted,
    may_touch,
    rows_gap,
    solid_at,
    wider_by,
    widest,
)
from ulna.kernels.collision.reached import (
    NEVER,
    ball_bounds,
    core_offset,
    core_radius,
    core_slope,
    has_exact_ball,
    push_reached,
    tree_is_reached,
)
from ulna.kernels.collision.scene import Mover, Reach
from ulna.kernels.layout import JOINT, REACH, SHAPE, SPHERE
from ulna.kernels.spatial.elementary import minimum
from ulna.kernels.spatial.se3 import constant_pose
from ulna.kernels.spatial.vectors import dot, load_vector, minus, origin


@kernel
def world_outcome(scene, carried, intervals, stack, like):
    """Whether a body touches an object in any lane; and 1.0 in the lanes in whose interval all of them are clear, else 0.0.

    The last balls first: a hand touches something more often than a base.
    """
    _, still, stop, margin, apart, of_world = intervals
    clear, bodies, balls = splat(1.0, like), scene.bodies, carried.balls
    for back in range(balls.shape[0]):
        g = balls.shape[0] - 1 - back
        joint, slack = int(balls[g, BALL_JOINT]), carried.slacks[g] + of_world + margin + widest(apart, 1)
        p, reach = load_vector(carried.ball_rows, 7 * g), load(carried.ball_rows, 7 * g + 6) + slack
        within = where(clear > 0.0, reach, slack if stop else NEVER)
        n_near, of_tree = objects_near(scene, carried, intervals, g, p, within, slack), within - tree_spare(apart)
        in_tree = scene.root >= 0 and tree_is_reached(scene.nodes, scene.root, p, of_tree, BALLS * balls[g, BALL_RADIUS], stack)
        if n_near == 0 and not in_tree:
            continue
        place_bodies_of(bodies, carried, g, like)
        turning = turning_at(carried, joint, still, like)
        for m in range(carried.first[g], carried.first[g + 1]):
            mover, found = (g, carried.order[m], turning), (n_near, in_tree, stack)
            touches, clear = body_outcome(scene, carried, intervals, mover, found, slack, clear)
            if touches and stop:
                return True, clear
        if not stop and not any_lane(clear > 0.0):
            return False, clear
    return False, clear


@kernel
def spare(scene, apart, row):
    """How much less than the widest margin the object of a row needs [m]."""
    return widest(apart, 1) - wider_by(scene, apart, row)


@kernel
def tree_spare(apart):
    """How much less than the widest margin all objects in the BVH need [m]."""
    return widest(apart, 1) - widest(apart, 2)


@kernel
def objects_near(scene, carried, intervals, g, p, of_all, slack):
    """Write to ``near`` the unindexed objects that ball g, with its center p, may reach in any lane; how many.

    of_all: how far a point of it gets, and ``slack``, which is what rounding and the widest margin add to it.
    """
    objects, n, n_joints, ball = scene.objects, 0, scene.joints.shape[0], BALLS * carried.balls[g, BALL_RADIUS]
    for o in range(scene.first, scene.end):
        less = spare(scene, intervals.apart, o)
        within, d = of_all - less, minus(p, (objects[o, 3], objects[o, 7], objects[o, 11]))
        most = within + (ball + BALLS * objects[o, REACH])
        if not any_lane((dot(d, d) <= most * most) & (within >= 0.0)):
            continue
        b, radius = constant_pose(objects, o, p[0]), core_radius(objects, o) + ball
        e, most = core_offset(p, objects, o, b), within + radius
        near = (dot(e, e) <= most * most) & (within >= 0.0)
        if not intervals.still and any_lane(near):
            slope = core_slope(e, load_vector(carried.ball_rows, 7 * g + 3), objects, o, b)
            most = center_way(carried, g, n_joints, slope, intervals.half) + (slack - less + radius)
            near = near & (dot(e, e) <= most * most)
        if any_lane(near):
            carried.near[n] = o
            n += 1
    return n


@kernel
def body_outcome(scene, carried, intervals, mover, found, slack, clear):
    """``world_outcome`` for one body alone.

    mover: its ball, the body, and how fast its joint turns; found: how many objects are in ``near``, whether those of the tree
    are to be searched, and the stack for that.
    """
    half, still, stop, margin, apart, _ = intervals
    bodies, (g, k, turning), (n_near, in_tree, stack) = scene.bodies, mover, found
    p, v = load_vector(carried.center_rows, 3 * k), body_velocity(carried, g, k, still, half)
    way = body_way(carried, g, scene.joints.shape[0], v, turning * bodies[k, REACH], half, still) + slack
    a, radius, otherwise = pose_of(bodies, k, carried, p, half), BALLS * bodies[k, REACH], slack if stop else NEVER
    within = where(clear > 0.0, way, otherwise)
    bounds, at, top = ball_bounds(p, within - tree_spare(apart) + radius), 0, 0
    if in_tree:
        stack[0], top = scene.root, 1
    while at < n_near or top > 0:
        if at < n_near:
            o = carried.near[at]
            at += 1
        else:
            top -= 1
            node = stack[top]
            if node >= 0:
                if is_all_excepted(scene, apart, k, node):
                    continue
                body = body_at(scene, k, a), p, bounds
                top = push_reached(scene.nodes, node, body, within - tree_spare(apart), apart, stack, top)
                continue
            o = -1 - node
        theirs = solid_at(scene, o, half)
        row = theirs.row
        if may_touch(scene, k, row) or is_excepted(scene, apart, k, row):
            continue
        less = spare(scene, apart, row)
        reach = Reach(way - less, within - less, slack - less, margin + wider_by(scene, apart, row))
        touches, now = object_outcome(scene, carried, intervals, Mover(g, k, a, p, v), theirs, reach, clear)
        if touches and stop:
            return True, now
        if any_lane(now < clear):
            clear, within = now, where(now > 0.0, way, otherwise)
            bounds = ball_bounds(p, within - tree_spare(apart) + radius)
            if not stop and not any_lane(clear > 0.0):
                return False, clear
    return False, clear


@kernel
def is_all_excepted(scene, apart, k, node):
    """Whether all solids below a node are of one object that body k may touch by ``apart``."""
    if apart is None:
        return False
    if apart.touching.shape[0] == 0:
        return False
    row = row_of_one_object(scene.nodes, scene.objects, node)
    return row >= 0 and is_excepted(scene, apart, k, row)


@kernel
def object_outcome(scene, carried, intervals, mover, theirs, reach, clear):
    """``world_outcome`` for one body (``scene.Mover``) and one object alone."""
    bodies, (g, k, a, p, v), (way, within, slack, margin) = scene.bodies, mover, reach
    objects, o, b = scene.objects, theirs.row, theirs.pose
    e, radius, nearer = core_offset(p, objects, o, b), core_radius(objects, o) + BALLS * bodies[k, REACH], way
    most = within + radius
    if not any_lane((dot(e, e) <= most * most) & (within >= 0.0)):
        return False, clear
    distance = sqrt(dot(e, e)) - radius
    if not intervals.still:
        slope = core_slope(e, v, objects, o, b)
        nearer = minimum(way, center_way(carried, g, scene.joints.shape[0], slope, intervals.half) + slack)
        if not any_lane(distance <= minimum(nearer, within)):
            return False, clear
    away = distance > nearer
    kind, other = int(bodies[k, SHAPE]), int(objects[o, SHAPE])
    if not has_exact_ball(kind, other):
        e = core_offset(origin(b), bodies, k, a)
        distance = sqrt(dot(e, e)) - (core_radius(bodies, k) + BALLS * objects[o, REACH])
        if not any_lane(distance <= within):
            return False, clear
        if not has_exact_ball(other, kind):
            distance = gap_or_contact(body_at(scene, k, a), theirs, within, margin, slack - margin)
        away = away | (distance > way)
    return any_lane(distance <= margin), where(away, clear, 0.0)


@kernel
def pose_of(bodies, k, carried, p, like):
    """The pose of body k, with its center p; that of a sphere is not turned, since nothing depends on it."""
    if int(bodies[k, SHAPE]) == SPHERE:
        one, none = splat(1.0, like), splat(0.0, like)
        return one, none, none, p[0], none, one, none, p[1], none, none, one, p[2]
    return frame_pose(bodies, k, carried.joint_rows, like)


@kernel
def self_outcome(scene, carried, intervals, clear, like):
    """``world_outcome`` for the pairs of the robot's own bodies instead; lanes that are not clear stay so."""
    half, still, stop = intervals.half, intervals.still, intervals.stop
    bodies, balls, groups = scene.bodies, carried.balls, carried.groups
    for e in range(groups.shape[0]):
        a, b = groups[e, GROUP_A], groups[e, GROUP_B]
        d = minus(load_vector(carried.ball_rows, 7 * a), load_vector(carried.ball_rows, 7 * b))
        slack, radii = carried.slacks[a] + carried.slacks[b], BALLS * (balls[a, BALL_RADIUS] + balls[b, BALL_RADIUS])
        most = radii + slack + load(carried.ball_rows, 7 * a + 6) + load(carried.ball_rows, 7 * b + 6)
        if not any_lane(dot(d, d) <= most * most):
            continue
        way, group = splat(slack, like), (a, b, groups[e, GROUP_SHARED])
        if not still:
            v = minus(load_vector(carried.ball_rows, 7 * a + 3), load_vector(carried.ball_rows, 7 * b + 3))
            most = radii + (approach_way(scene.joints, carried, group, d, v, half) + slack)
            if not any_lane(dot(d, d) <= most * most):
                continue
            way = pair_way(scene.joints, carried, group, half, like) + slack
        place_bodies_of(bodies, carried, a, like)
        place_bodies_of(bodies, carried, b, like)
        for run in range(groups[e, GROUP_FIRST], groups[e, GROUP_END]):
            i = carried.runs[run, RUN_BODY]
            p = load_vector(carried.center_rows, 3 * i)
            d = minus(p, load_vector(carried.ball_rows, 7 * b))
            most = way + BALLS * (bodies[i, REACH] + balls[b, BALL_RADIUS])
            if not any_lane((dot(d, d) <= most * most) & (clear > 0.0)):
                continue
            for m in range(carried.runs[run, RUN_FIRST], carried.runs[run, RUN_END]):
                pair = e, i, carried.others[m]
                touches, clear = pair_outcome(scene, carried, intervals, pair, p, (way, slack), clear)
                if touches and stop:
                    return True, clear
    return False, clear


@kernel
def pair_outcome(scene, carried, intervals, pair, p, reach, clear):
    """``self_outcome`` for two bodies. pair: the group of their two balls, and the bodies; p: the center of the first.

    reach: how much nearer a point of one comes to one of the other, with what rounding adds; and that alone.
    """
    bodies, (_, i, j), (way, slack) = scene.bodies, pair, reach
    half, stop, q = intervals.half, intervals.stop, load_vector(carried.center_rows, 3 * j)
    d, radii = minus(p, q), BALLS * (bodies[i, REACH] + bodies[j, REACH])
    within = where(clear > 0.0, way, splat(slack, way) if stop else splat(NEVER, way))
    most = within + radii
    near = (dot(d, d) <= most * most) & (within >= 0.0)
    if not any_lane(near & (clear > 0.0)):
        return False, clear
    distance, nearer = sqrt(dot(d, d)) - radii, way
    if int(bodies[i, SHAPE]) != SPHERE or int(bodies[j, SHAPE]) != SPHERE:
        of_j = frame_pose(bodies, j, carried.joint_rows, half)
        offset, most = core_offset(p, bodies, j, of_j), within + (core_radius(bodies, j) + BALLS * bodies[i, REACH])
        near = near & (dot(offset, offset) <= most * most)
        if not any_lane(near & (clear > 0.0)):
            return False, clear
        of_i = frame_pose(bodies, i, carried.joint_rows, half)
        distance = gap_or_contact(body_at(scene, i, of_i), body_at(scene, j, of_j), where(near, within, NEVER), 0.0, slack)
    else:
        nearer = minimum(way, spheres_way(scene, carried, intervals, pair, (p, q)) + slack)
    return any_lane(near & (distance <= 0.0)), where(near & (distance <= nearer), 0.0, clear)


@kernel
def spheres_way(scene, carried, intervals, pair, centers):
    """How much nearer two spheres of a group with these centers come within ``half``. A turn about its own center moves none.

    pair: as for ``pair_outcome``.
    """
    half = intervals.half
    if intervals.still:
        return splat(0.0, half)
    groups, (e, i, j), (p, q) = carried.groups, pair, centers
    v_p = joint_twist(carried, int(scene.bodies[i, JOINT]), p, half)[0]
    v_q = joint_twist(carried, int(scene.bodies[j, JOINT]), q, half)[0]
    group = groups[e, GROUP_A], groups[e, GROUP_B], groups[e, GROUP_SHARED]
    return approach_way(scene.joints, carried, group, minus(p, q), minus(v_p, v_q), half)


@kernel
def gap_or_contact(ours, theirs, reach, margin, rounding):
    """A lower bound of the distance of two bodies, exact enough to know whether it is above ``reach``, and above a margin.

    Where ``reach`` is NEVER it may be any lower bound.
    """
    distance = posed_gap(ours, theirs, reach, rounding)
    near = (distance <= margin) & (reach >= 0.0)
    if any_lane(near):
        again = posed_gap(ours, theirs, where(near, margin, NEVER), rounding)
        distance = where(near, again, distance)
    return distance


@routine
def posed_gap(ours, theirs, reach, rounding):
    """``posed_pair.rows_gap``, called and not inlined: it takes longest to compile."""
    return rows_gap(ours, theirs, reach, rounding)
