"""Decides which of eight intervals of an edge are free.

An interval has one of three outcomes. Each follows from one distance d at its middle, and from a bound on the motion in it,
``reach``:

- d <= margin: something touches, so the edge is not free, and the search may end;
- d > reach + margin: the pair is clear in all of the interval;
- between: unknown, and the interval is split.

Balls are compared first. One ball contains all bodies of a joint. It is compared with the boxes of objects and with the boxes of
nodes of the BVH (``reached``). The balls of two joints are compared with each other. If a ball is near, the bodies in it are
placed and compared, by their own bounding balls first. For a ball, only the motion of its center towards the box counts
(``ball_motion``).

If one of two bodies is a sphere, and the other a sphere, capsule, box or half-space, the ball's distance is their exact distance.
For other shapes a lower bound of the distance is computed (``posed_pair.rows_gap``), just far enough to decide whether it is
above ``reach``. If this bound is at most the margin, a second bound is computed, just far enough to compare it with the margin.
So the outcome "clear" is certain. The outcome "touches" is certain up to the resolution of the second bound.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import any_lane, load, splat, sqrt, where
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.collision.ball_motion import (
    approach_bound,
    body_motion,
    body_velocity,
    center_approach,
    joint_twist,
    pair_approach,
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
    extra_margin,
    is_excepted,
    max_extra_margin,
    may_touch,
    rows_gap,
    solid_at,
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
    """Whether a body touches an object in any lane, and 1.0 in each lane whose interval is clear, else 0.0.

    The last balls come first: a hand touches something more often than a base.
    """
    _, is_instant, stop_at_contact, margin, margins, object_rounding = intervals
    clear, bodies, balls = splat(1.0, like), scene.bodies, carried.balls
    for from_end in range(balls.shape[0]):
        g = balls.shape[0] - 1 - from_end
        joint, slack = int(balls[g, BALL_JOINT]), carried.slacks[g] + object_rounding + margin + max_extra_margin(margins, 1)
        p, reach = load_vector(carried.ball_rows, 7 * g), load(carried.ball_rows, 7 * g + 6) + slack
        within = where(clear > 0.0, reach, slack if stop_at_contact else NEVER)
        n_near, of_tree = find_near_objects(scene, carried, intervals, g, p, within, slack), within - unused_tree_margin(margins)
        in_tree = scene.root >= 0 and tree_is_reached(scene, scene.root, p, of_tree, BALLS * balls[g, BALL_RADIUS], stack)
        if n_near == 0 and not in_tree:
            continue
        place_bodies_of(bodies, carried, g, like)
        turning = turning_at(carried, joint, is_instant, like)
        for m in range(carried.first[g], carried.first[g + 1]):
            mover, candidates = (g, carried.order[m], turning), (n_near, in_tree, stack)
            touches, clear = body_outcome(scene, carried, intervals, mover, candidates, slack, clear)
            if touches and stop_at_contact:
                return True, clear
        if not stop_at_contact and not any_lane(clear > 0.0):
            return False, clear
    return False, clear


@kernel
def unused_margin(scene, margins, row):
    """The widest margin minus the margin of a row's object [m]."""
    return max_extra_margin(margins, 1) - extra_margin(scene, margins, row)


@kernel
def unused_tree_margin(margins):
    """The widest margin minus the widest margin of the objects in the BVH [m]."""
    return max_extra_margin(margins, 1) - max_extra_margin(margins, 2)


@kernel
def find_near_objects(scene, carried, intervals, g, p, motion, slack):
    """Write the unindexed objects that ball g, with its center p, may reach in any lane to ``near``; their number.

    motion: The bound on the motion of a point of the ball, with ``slack``. slack: The part from rounding and the widest margin.
    """
    objects, n, n_joints, ball = scene.objects, 0, scene.joints.shape[0], BALLS * carried.balls[g, BALL_RADIUS]
    for o in range(scene.first, scene.end):
        unused = unused_margin(scene, intervals.margins, o)
        within, d = motion - unused, minus(p, (objects[o, 3], objects[o, 7], objects[o, 11]))
        limit = within + (ball + BALLS * objects[o, REACH])
        if not any_lane((dot(d, d) <= limit * limit) & (within >= 0.0)):
            continue
        b, radius = constant_pose(objects, o, p[0]), core_radius(objects, o) + ball
        e, limit = core_offset(p, objects, o, b), within + radius
        near = (dot(e, e) <= limit * limit) & (within >= 0.0)
        if not intervals.is_instant and any_lane(near):
            slope = core_slope(e, load_vector(carried.ball_rows, 7 * g + 3), objects, o, b)
            limit = center_approach(carried, g, n_joints, slope, intervals.half) + (slack - unused + radius)
            near = near & (dot(e, e) <= limit * limit)
        if any_lane(near):
            carried.near[n] = o
            n += 1
    return n


@kernel
def body_outcome(scene, carried, intervals, mover, candidates, slack, clear):
    """``world_outcome`` for one body alone.

    mover: Its ball, the body, and the angular speed of its joint. candidates: The number of objects in ``near``, whether to
    search the tree, and the stack for the search.
    """
    half, is_instant, stop_at_contact, margin, margins, _ = intervals
    bodies, (g, k, turning), (n_near, in_tree, stack) = scene.bodies, mover, candidates
    p, v = load_vector(carried.center_rows, 3 * k), body_velocity(carried, g, k, is_instant, half)
    motion = body_motion(carried, g, scene.joints.shape[0], v, turning * bodies[k, REACH], half, is_instant) + slack
    a, radius, otherwise = pose_of(bodies, k, carried, p, half), BALLS * bodies[k, REACH], slack if stop_at_contact else NEVER
    within = where(clear > 0.0, motion, otherwise)
    bounds, n_seen, top = ball_bounds(p, within - unused_tree_margin(margins) + radius), 0, 0
    if in_tree:
        stack[0], top = scene.root, 1
    while n_seen < n_near or top > 0:
        if n_seen < n_near:
            o = carried.near[n_seen]
            n_seen += 1
        else:
            top -= 1
            node = stack[top]
            if node >= 0:
                if is_all_excepted(scene, margins, k, node):
                    continue
                body = body_at(scene, k, a), p, bounds
                top = push_reached(scene, node, body, within - unused_tree_margin(margins), margins, stack, top)
                continue
            o = -1 - node
        theirs = solid_at(scene, o, half)
        row = theirs.row
        if may_touch(scene, k, row) or is_excepted(scene, margins, k, row):
            continue
        unused = unused_margin(scene, margins, row)
        reach = Reach(motion - unused, within - unused, slack - unused, margin + extra_margin(scene, margins, row))
        touches, still_clear = object_outcome(scene, carried, intervals, Mover(g, k, a, p, v), theirs, reach, clear)
        if touches and stop_at_contact:
            return True, still_clear
        if any_lane(still_clear < clear):
            clear, within = still_clear, where(still_clear > 0.0, motion, otherwise)
            bounds = ball_bounds(p, within - unused_tree_margin(margins) + radius)
            if not stop_at_contact and not any_lane(clear > 0.0):
                return False, clear
    return False, clear


@kernel
def is_all_excepted(scene, margins, k, node):
    """Whether all solids below a node belong to one object that ``margins`` allows body k to touch."""
    if margins is None:
        return False
    if margins.touching.shape[0] == 0:
        return False
    row = row_of_one_object(scene.nodes, scene.objects, node)
    return row >= 0 and is_excepted(scene, margins, k, row)


@kernel
def object_outcome(scene, carried, intervals, mover, theirs, reach, clear):
    """``world_outcome`` for one body (``scene.Mover``) and one object alone."""
    bodies, (g, k, a, p, v), (motion, within, slack, margin) = scene.bodies, mover, reach
    objects, o, b = scene.objects, theirs.row, theirs.pose
    e, radius, approach = core_offset(p, objects, o, b), core_radius(objects, o) + BALLS * bodies[k, REACH], motion
    limit = within + radius
    if not any_lane((dot(e, e) <= limit * limit) & (within >= 0.0)):
        return False, clear
    distance = sqrt(dot(e, e)) - radius
    if not intervals.is_instant:
        slope = core_slope(e, v, objects, o, b)
        approach = minimum(motion, center_approach(carried, g, scene.joints.shape[0], slope, intervals.half) + slack)
        if not any_lane(distance <= minimum(approach, within)):
            return False, clear
    is_clear = distance > approach
    kind, object_kind = int(bodies[k, SHAPE]), int(objects[o, SHAPE])
    if not has_exact_ball(kind, object_kind):
        e = core_offset(origin(b), bodies, k, a)
        distance = sqrt(dot(e, e)) - (core_radius(bodies, k) + BALLS * objects[o, REACH])
        if not any_lane(distance <= within):
            return False, clear
        if not has_exact_ball(object_kind, kind):
            distance = gap_or_contact(body_at(scene, k, a), theirs, within, margin, slack - margin)
        is_clear = is_clear | (distance > motion)
    return any_lane(distance <= margin), where(is_clear, clear, 0.0)


@kernel
def pose_of(bodies, k, carried, p, like):
    """The pose of body k, with its center p; a sphere's pose is not rotated, since nothing depends on it."""
    if int(bodies[k, SHAPE]) == SPHERE:
        one, none = splat(1.0, like), splat(0.0, like)
        return one, none, none, p[0], none, one, none, p[1], none, none, one, p[2]
    return frame_pose(bodies, k, carried.joint_rows, like)


@kernel
def self_outcome(scene, carried, intervals, clear, like):
    """``world_outcome`` for the pairs of the robot's own bodies; lanes that are not clear stay so."""
    half, is_instant, stop_at_contact = intervals.half, intervals.is_instant, intervals.stop_at_contact
    bodies, balls, groups = scene.bodies, carried.balls, carried.groups
    for e in range(groups.shape[0]):
        a, b = groups[e, GROUP_A], groups[e, GROUP_B]
        d = minus(load_vector(carried.ball_rows, 7 * a), load_vector(carried.ball_rows, 7 * b))
        slack, radii = carried.slacks[a] + carried.slacks[b], BALLS * (balls[a, BALL_RADIUS] + balls[b, BALL_RADIUS])
        limit = radii + slack + load(carried.ball_rows, 7 * a + 6) + load(carried.ball_rows, 7 * b + 6)
        if not any_lane(dot(d, d) <= limit * limit):
            continue
        motion, group = splat(slack, like), (a, b, groups[e, GROUP_SHARED])
        if not is_instant:
            v = minus(load_vector(carried.ball_rows, 7 * a + 3), load_vector(carried.ball_rows, 7 * b + 3))
            limit = radii + (approach_bound(scene.joints, carried, group, d, v, half) + slack)
            if not any_lane(dot(d, d) <= limit * limit):
                continue
            motion = pair_approach(scene.joints, carried, group, half, like) + slack
        place_bodies_of(bodies, carried, a, like)
        place_bodies_of(bodies, carried, b, like)
        for run in range(groups[e, GROUP_FIRST], groups[e, GROUP_END]):
            i = carried.runs[run, RUN_BODY]
            p = load_vector(carried.center_rows, 3 * i)
            d = minus(p, load_vector(carried.ball_rows, 7 * b))
            limit = motion + BALLS * (bodies[i, REACH] + balls[b, BALL_RADIUS])
            if not any_lane((dot(d, d) <= limit * limit) & (clear > 0.0)):
                continue
            for m in range(carried.runs[run, RUN_FIRST], carried.runs[run, RUN_END]):
                pair = e, i, carried.others[m]
                touches, clear = pair_outcome(scene, carried, intervals, pair, p, (motion, slack), clear)
                if touches and stop_at_contact:
                    return True, clear
    return False, clear


@kernel
def pair_outcome(scene, carried, intervals, pair, p, reach, clear):
    """``self_outcome`` for two bodies. pair: The group of their two balls, and the bodies; p: the first center.

    reach: A bound on the approach of two points of the bodies, with rounding; and the rounding alone.
    """
    bodies, (_, i, j), (motion, slack) = scene.bodies, pair, reach
    half, stop_at_contact, q = intervals.half, intervals.stop_at_contact, load_vector(carried.center_rows, 3 * j)
    d, radii = minus(p, q), BALLS * (bodies[i, REACH] + bodies[j, REACH])
    within = where(clear > 0.0, motion, splat(slack, motion) if stop_at_contact else splat(NEVER, motion))
    limit = within + radii
    near = (dot(d, d) <= limit * limit) & (within >= 0.0)
    if not any_lane(near & (clear > 0.0)):
        return False, clear
    distance, approach = sqrt(dot(d, d)) - radii, motion
    if int(bodies[i, SHAPE]) != SPHERE or int(bodies[j, SHAPE]) != SPHERE:
        of_j = frame_pose(bodies, j, carried.joint_rows, half)
        offset, limit = core_offset(p, bodies, j, of_j), within + (core_radius(bodies, j) + BALLS * bodies[i, REACH])
        near = near & (dot(offset, offset) <= limit * limit)
        if not any_lane(near & (clear > 0.0)):
            return False, clear
        of_i = frame_pose(bodies, i, carried.joint_rows, half)
        distance = gap_or_contact(body_at(scene, i, of_i), body_at(scene, j, of_j), where(near, within, NEVER), 0.0, slack)
    else:
        approach = minimum(motion, spheres_approach(scene, carried, intervals, pair, (p, q)) + slack)
    return any_lane(near & (distance <= 0.0)), where(near & (distance <= approach), 0.0, clear)


@kernel
def spheres_approach(scene, carried, intervals, pair, centers):
    """Bound on the approach of two spheres of a group within ``half``. Rotations about their own centers do not count.

    pair: As for ``pair_outcome``. centers: The spheres' centers.
    """
    half = intervals.half
    if intervals.is_instant:
        return splat(0.0, half)
    groups, (e, i, j), (p, q) = carried.groups, pair, centers
    v_p = joint_twist(carried, int(scene.bodies[i, JOINT]), p, half)[0]
    v_q = joint_twist(carried, int(scene.bodies[j, JOINT]), q, half)[0]
    group = groups[e, GROUP_A], groups[e, GROUP_B], groups[e, GROUP_SHARED]
    return approach_bound(scene.joints, carried, group, minus(p, q), minus(v_p, v_q), half)


@kernel
def gap_or_contact(ours, theirs, reach, margin, rounding):
    """A lower bound of the distance of two bodies, exact enough to compare it with ``reach`` and with a margin.

    Where ``reach`` is NEVER it may be any lower bound.
    """
    distance = posed_gap(ours, theirs, reach, rounding)
    near = (distance <= margin) & (reach >= 0.0)
    if any_lane(near):
        exact_distance = posed_gap(ours, theirs, where(near, margin, NEVER), rounding)
        distance = where(near, exact_distance, distance)
    return distance


@routine
def posed_gap(ours, theirs, reach, rounding):
    """``posed_pair.rows_gap``, called and not inlined, since it takes longest to compile."""
    return rows_gap(ours, theirs, reach, rounding)
