"""Bounds the motion of each joint's bodies in an interval of an edge.

On q(t) = q_a + t (q_b - q_a), let c be the middle of an interval and h its half length. By Taylor's theorem, a point p of a body
moves from c by at most h |p'(c)| + h^2 / 2 max |p''|. Its velocity at the middle is exact. With r_k the rate of joint k, and M_k
the maximum distance of p from the axis of k (1 if k is prismatic),

    |p''| <= sum over k of |r_k| M_k (2 W_k + |r_k|),   W_k the sum of |r_i| of the revolute joints i that carry k.

The reason: a joint i that carries k rotates the vector dp/dq_k about the axis of i. The last |r_k| counts only if k is revolute.
The sum of |r_k| M_k bounds |p'| everywhere, and the smaller of the two bounds is taken. Seen from a joint that carries two
bodies, only the joints behind it move the bodies. This bounds the change of their distance.

The distance between a point and a convex body is a convex function of the point. Likewise the distance between two points is a
convex function of their difference: it is the length of this vector. So the distance stays above its tangent at the middle. With
n its gradient there,

    d(t) >= d(c) - h |n . p'(c)| - h^2 / 2 max |p''|.

To first order only the velocity along the line between the two counts. If rounding has moved p, the gradient belongs to the moved
point, and the inequality holds up to that rounding. A ball that rotates about its own center does not move.

A bound on the rounding errors is added to the motion. For each body it has two parts: a fraction of all lengths between it and
the base, and the rounding of each angle of q(t) times the lever arm of its joint.

Source of the idea of the second-order bound: Redon, Kheddar and Coquillart, Fast continuous collision detection between rigid
bodies (Eurographics 2002). The bound itself follows from the product of exponentials (Murray, Li and Sastry 1994, chapter 3).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import WIDTH, load, splat, sqrt, store
from ulna.kernels.chain.poses import tree_poses
from ulna.kernels.collision.collision_layout import (
    ASIDE,
    BALL_CENTER,
    BALL_JOINT,
    BALL_LENGTH,
    BALL_RADIUS,
    NODE_ROWS,
    PLACES,
    RATE,
    SLIDE,
    SLIDES,
    STEP_LENGTH,
    SWING,
    TURN,
)
from ulna.kernels.layout import COLUMN, FIXED, HALF_SPACE, KIND, OFFSET, PARENT, PRISMATIC, RATIO, REACH, SHAPE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import load_pose
from ulna.kernels.spatial.vectors import add_scaled, cross, dot, load_vector, minus, origin, plus, store_vector, transform, z_axis

ROUNDING = 1e-12  # of the lengths between a body and the base: larger than the rounding of poses and gaps
ANGLE = 2e-15  # of an angle: larger than the rounding of the line in q, of a mimic's ratio and of the reduction of many turns
INSTANT = 1e-15  # of t: rounding may leave gaps up to this between neighboring intervals
MIN_DISTANCE = 1e-150  # [m]: lower bound of divisors; points nearer than rounding are never clear


@kernel
def write_motion(joints, q_a, q_b, spread, carried):
    """Write rates, turns, speeds, bends and slacks of an edge.

    With a spread, the bounds hold for all configurations within ``spread``, shape (n_dof,) [rad or m], of the edge.
    """
    write_steps(joints, q_a, q_b, spread, carried.steps)
    balls = carried.balls
    for g in range(balls.shape[0]):
        joint, length = int(balls[g, BALL_JOINT]), balls[g, BALL_LENGTH]
        carried.slacks[g] = write_bounds(joints, carried.steps, joint, length, carried.speeds, carried.bends, g)


@kernel
def write_steps(joints, q_a, q_b, spread, steps):
    """Write the motion of each joint along an edge, or along all lines within ``spread`` of it."""
    for i in range(joints.shape[0]):
        column, parent, kind = int(joints[i, COLUMN]), int(joints[i, PARENT]), int(joints[i, KIND])
        rate = 0.0 if kind == FIXED else joints[i, RATIO] * (q_b[column] - q_a[column])
        before = steps[parent, TURN] if parent >= 0 else 0.0
        aside = abs(joints[i, RATIO]) * spread[column]
        travel = abs(joints[i, RATIO]) * max(abs(q_a[column]), abs(q_b[column])) + abs(joints[i, OFFSET]) + aside
        slides = kind == PRISMATIC
        steps[i, RATE], steps[i, TURN] = rate, before if slides else before + abs(rate)
        steps[i, SLIDE], steps[i, ASIDE] = travel if slides else 0.0, aside if slides else ANGLE * travel + aside
        steps[i, SWING], steps[i, SLIDES] = 2.0 * before if slides else 2.0 * before + abs(rate), 1.0 if slides else 0.0


@kernel
def write_bounds(joints, steps, joint, length, speeds, bends, g):
    """Write bounds on speed and acceleration of a joint's point, as seen from each joint and the base.

    length: The maximum distance of the point from the joint's origin [m]. Returns the displacement by rounding and spread, at
    most [m].
    """
    speed, bend, slack, i, n = 0.0, 0.0, 0.0, joint, joints.shape[0]
    while i >= 0:
        speeds[g, i], bends[g, i] = speed, bend
        length += steps[i, SLIDE]
        lever = 1.0 if steps[i, SLIDES] > 0.0 else length
        rate = abs(steps[i, RATE]) * lever
        slack += steps[i, ASIDE] * lever
        speed += rate
        bend += rate * steps[i, SWING]
        length += steps[i, STEP_LENGTH]
        i = int(joints[i, PARENT])
    speeds[g, n], bends[g, n] = speed, bend
    return slack + ROUNDING * length


@kernel
def fastest_ball(joints, carried):
    """The maximum speed of any point of the robot along the edge [m]."""
    fastest, balls, last = 0.0, carried.balls, joints.shape[0]
    for g in range(balls.shape[0]):
        fastest = max(fastest, carried.speeds[g, last])
    return fastest


@kernel
def place_balls(joints, q_rows, half, is_instant, carried):
    """Write joints and balls at q, their velocities, and a bound on the motion of a ball's points within ``half``.

    is_instant: Whether ``half`` is 0, so that no velocities are needed.
    """
    n, balls, like = joints.shape[0], carried.balls, load(q_rows, 0)
    tree_poses(joints, q_rows, carried.joint_rows)
    if not is_instant:
        write_twists(joints, carried, like)
    for g in range(balls.shape[0]):
        joint = int(balls[g, BALL_JOINT])
        p, motion = ball_center(carried, g, joint, like), splat(0.0, like)
        if not is_instant:
            v, w = joint_twist(carried, joint, p, like)
            motion = motion_bound(carried.speeds[g, n], carried.bends[g, n], v, sqrt(dot(w, w)) * balls[g, BALL_RADIUS], half)
            store_vector(carried.ball_rows, 7 * g + 3, v)
        store_vector(carried.ball_rows, 7 * g, p)
        store(carried.ball_rows, 7 * g + 6, motion)
        carried.is_placed[g] = 0


@kernel
def write_twists(joints, carried, like):
    """Write the velocities of the joints' origins along the edge, and their angular velocities."""
    for i in range(joints.shape[0]):
        a, parent = load_pose(carried.joint_rows, i), int(joints[i, PARENT])
        v, w = joint_twist(carried, parent, origin(a), like)
        if int(joints[i, KIND]) == PRISMATIC:
            v = add_scaled(v, carried.steps[i, RATE], z_axis(a))
        else:
            w = add_scaled(w, carried.steps[i, RATE], z_axis(a))
        store_vector(carried.twist_rows, 6 * i, v)
        store_vector(carried.twist_rows, 6 * i + 3, w)


@kernel
def place_bodies_of(bodies, carried, g, like):
    """Write the origins of the bodies of a ball, unless they are already written."""
    if carried.is_placed[g] == 0:
        carried.is_placed[g], joint = 1, int(carried.balls[g, BALL_JOINT])
        for m in range(carried.first[g], carried.first[g + 1]):
            k = carried.order[m]
            center = splat(bodies[k, 3], like), splat(bodies[k, 7], like), splat(bodies[k, 11], like)
            position = center if joint < 0 else transform(load_pose(carried.joint_rows, joint), center)
            store_vector(carried.center_rows, 3 * k, position)


@kernel
def ball_center(carried, g, joint, like):
    """The center of a ball in the base frame [m]."""
    c, balls = BALL_CENTER, carried.balls
    center = splat(balls[g, c], like), splat(balls[g, c + 1], like), splat(balls[g, c + 2], like)
    return center if joint < 0 else transform(load_pose(carried.joint_rows, joint), center)


@kernel
def joint_twist(carried, joint, p, like):
    """The velocity of a point p that a joint carries, and the joint's angular velocity, along the edge."""
    w = joint_turn(carried, joint, like)
    if joint < 0:
        return w, w
    arm = minus(p, origin(load_pose(carried.joint_rows, joint)))
    return plus(load_vector(carried.twist_rows, 6 * joint), cross(w, arm)), w


@kernel
def joint_turn(carried, joint, like):
    """The angular velocity of a joint along the edge; zero for the base."""
    if joint < 0:
        return splat(0.0, like), splat(0.0, like), splat(0.0, like)
    return load_vector(carried.twist_rows, 6 * joint + 3)


@kernel
def turning_at(carried, joint, is_instant, like):
    """The angular speed of a joint along the edge [rad]; 0 if ``is_instant``."""
    if is_instant:
        return splat(0.0, like)
    w = joint_turn(carried, joint, like)
    return sqrt(dot(w, w))


@kernel
def body_velocity(carried, g, k, is_instant, like):
    """The velocity of the center of body k, of ball g, along the edge [m]; 0 if ``is_instant``."""
    if is_instant:
        return splat(0.0, like), splat(0.0, like), splat(0.0, like)
    return joint_twist(carried, int(carried.balls[g, BALL_JOINT]), load_vector(carried.center_rows, 3 * k), like)[0]


@kernel
def body_motion(carried, g, n, v, turning, half, is_instant):
    """Bound on the motion of a body of ball g within ``half``.

    v: The velocity of the body's center. turning: The speed that the body's rotation adds to its points. n: The number of joints.
    """
    if is_instant:
        return splat(0.0, half)
    return motion_bound(carried.speeds[g, n], carried.bends[g, n], v, turning, half)


@kernel
def motion_bound(speed, bend, v, turning, half):
    """Bound on a point's motion within ``half``, from its maximum speed, or from its velocity and its acceleration."""
    by_taylor = half * (sqrt(dot(v, v)) + turning) + (0.5 * bend) * half * half
    return minimum(speed * half, by_taylor) * (1.0 + ROUNDING)


@kernel
def pair_approach(joints, carried, group, half, like):
    """Bound on the approach of two points of two balls within ``half``, as seen from their shared joint.

    group: The two balls, and the last joint that carries both.
    """
    a, b, shared = group
    p, q = load_vector(carried.ball_rows, 7 * a), load_vector(carried.ball_rows, 7 * b)
    v_a, w = joint_twist(carried, shared, p, like)
    v_b = joint_twist(carried, shared, q, like)[0]
    seen_a = minus(load_vector(carried.ball_rows, 7 * a + 3), v_a)
    seen_b = minus(load_vector(carried.ball_rows, 7 * b + 3), v_b)
    turning = turning_of(carried, a, w, like) + turning_of(carried, b, w, like)
    speed, bend = pair_bounds(joints, carried, a, b, shared)
    return motion_bound(speed, bend, minus(seen_b, seen_a), turning, half)


@kernel
def pair_bounds(joints, carried, a, b, shared):
    """Bounds on relative speed and acceleration of points of two balls, as seen from their shared joint."""
    column, turn = (joints.shape[0], 0.0) if shared < 0 else (shared, carried.steps[shared, TURN])
    speed = carried.speeds[a, column] + carried.speeds[b, column]
    return speed, max(carried.bends[a, column] + carried.bends[b, column] - 2.0 * turn * speed, 0.0)


@kernel
def approach_bound(joints, carried, group, d, v, half):
    """Bound on the approach of two points, each fixed to a ball, within ``half``.

    group: The two balls, and the joint that carries both. d: The difference of the points. v: The difference of their velocities,
    as seen from any joint: a rotation of both does not change ``dot(d, v)``.
    """
    n, (a, b, shared) = joints.shape[0], group
    speed, bend = pair_bounds(joints, carried, a, b, shared)
    return tangent_bound(speed, bend, component_along(d, v), carried.speeds[a, n] + carried.speeds[b, n], half)


@kernel
def component_along(d, v):
    """The component of v in the direction of d; 0 if d is 0."""
    return dot(d, v) / maximum(sqrt(dot(d, d)), MIN_DISTANCE)


@kernel
def center_approach(carried, g, n, slope, half):
    """Bound on the approach of the center of a ball, or of its body, to a convex object within ``half``.

    n: The number of joints. slope: The rate of change of the distance at the middle.
    """
    return tangent_bound(carried.speeds[g, n], carried.bends[g, n], slope, carried.speeds[g, n], half)


@kernel
def tangent_bound(speed, bend, slope, fastest, half):
    """Bound on the decrease of a distance within ``half``, from its slope at the middle, or from the maximum speed.

    fastest: The speed of the points as seen from the base, for the rounding of the slope.
    """
    by_tangent = half * (abs(slope) + ROUNDING * fastest) + (0.5 * bend) * half * half
    return minimum(speed * half, by_tangent) * (1.0 + ROUNDING)


@kernel
def turning_of(carried, g, w_shared, like):
    """The speed of a ball's points by the ball's rotation, as seen from a rotating frame."""
    balls = carried.balls
    w = minus(joint_turn(carried, int(balls[g, BALL_JOINT]), like), w_shared)
    return sqrt(dot(w, w)) * balls[g, BALL_RADIUS]


@kernel
def offset_length(table, i):
    """The distance of a row's frame from its parent frame [m]."""
    return sqrt(table[i, 3] * table[i, 3] + table[i, 7] * table[i, 7] + table[i, 11] * table[i, 11])


@kernel
def world_rounding(scene):
    """Bound on the rounding error of the points of all objects [m].

    It comes from the unindexed objects and from the AABBs at the BVH's root.
    """
    largest, objects, nodes = 0.0, scene.objects, scene.nodes
    for w in range(scene.first, scene.end):
        length = offset_length(objects, w)
        largest = max(largest, length if int(objects[w, SHAPE]) == HALF_SPACE else length + objects[w, REACH])
    if scene.root >= 0:
        low = NODE_ROWS * (scene.root // PLACES)
        high = low + 3
        for child in range(WIDTH):
            if nodes[low, child] <= nodes[high, child]:  # otherwise the child is missing
                for axis in range(3):
                    largest = max(largest, 4.0 * max(abs(nodes[low + axis, child]), abs(nodes[high + axis, child])))
    return ROUNDING * largest
