"""Bounds how far a frame of the robot gets from where it is to be kept, in an interval of an edge.

A constraint compares a frame of the robot, a, with another frame, b, of the base or of the robot: the displacement u of a's
origin in the axes of b, and the differences x of their z axes, or of all three axes in one vector. An angle theta between two
axes, or of a rotation, makes

    |x| = 2 sin(theta / 2)    of one axis,        |x| = 2 sqrt(2) sin(theta / 2)    of three,

so a tolerance of the angle is one of |x|. On an edge, in an interval with middle c and half length h (Taylor, with a remainder
for vectors), with all motion as b sees it:

    |u_k| <= |u_k(c)| + h |u_k'(c)| + h^2 / 2 max |u''|,
    |x|   <= max |x(c) +- h x'(c)| + h^2 / 2 s W^2,               s = 1 of one axis, sqrt(2) of three.

W is the sum of |r_i| of the joints between a and b that turn: those that carry both move neither as the other sees it. An axis is
a product of rotations by the joints' angles and of constant ones, so its second derivative is a sum over pairs of joints of
r_i r_k times a vector of length 1 at most; of three axes one of Frobenius norm sqrt(2), that of the generator of a rotation. The
first derivatives are bounded by the greatest speed of a point, and by s W; the smaller of both bounds is taken. What rounding,
and the spread beside the edge, may add is part of the value.

Seen from the joint that carries both, or from the base, the line d from b to a changes with |d'| <= S and |d''| <= B
(``ball_motion.pair_bounds``), so it is never longer than D = |u(c)| + h S. The axes of b turn with W_b at most, and u_k is the
product of d and such an axis. Hence, by the product rule,

    |u'| <= S + W_b D,        |u''| <= B + 2 W_b S + W_b^2 D.

If an axis is to point at b's origin, x is its difference from the direction g = -u / |u|. While |u| >= m,

    |g'| <= |u'| / m,        |g''| <= |u''| / m + 2 / sqrt(3) |u'|^2 / m^2:

with u' split into p along g and n across, what g'' has besides u'' is 2 p n across g and n^2 along g, over |u|^2.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, sqrt
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.collision.ball_motion import ROUNDING, joint_twist, offset_length, pair_bounds, write_bounds
from ulna.kernels.collision.collision_layout import ASIDE, SLIDES, TURN
from ulna.kernels.layout import JOINT, PARENT
from ulna.kernels.planning.constraint_records import ALL_AXES, MIN_LENGTH, NO_AXIS, TOWARDS
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import (
    cross,
    dot,
    minus,
    origin,
    rotate_inverse,
    scaled,
    transform_inverse,
    x_axis,
    y_axis,
    z_axis,
)

_INF, _ROOT_TWO, _BENT = float("inf"), 1.4142135623730951, 1.1547005383792517  # sqrt(2), 2 / sqrt(3)


@kernel
def write_keep_bounds(joints, keeps, moving, slacks):
    """Write how fast the origins of each constraint's two frames can move, and what rounding and the spread add.

    moving: its speeds and bends have two rows for each constraint, its frame's and that of the other one. slacks: (n, 3): what
    is added to the displacement of the origins and to differences of axes, and how far the axes of the other frame may be turned.
    """
    for i in range(keeps.allowed.shape[0]):
        a, b = 2 * i, 2 * i + 1
        joint_a, joint_b = int(keeps.frames[a, JOINT]), int(keeps.frames[b, JOINT])
        aside = write_bounds(joints, moving.steps, joint_a, keeps.allowed[i].lever, moving.speeds, moving.bends, a)
        far = write_bounds(joints, moving.steps, joint_b, offset_length(keeps.frames, b), moving.speeds, moving.bends, b)
        slacks[i, 0], slacks[i, 2] = aside + far, turned_aside(joints, moving.steps, joint_b)
        slacks[i, 1] = _ROOT_TWO * (turned_aside(joints, moving.steps, joint_a) + slacks[i, 2] + ROUNDING)


@kernel
def turned_aside(joints, steps, joint):
    """By what angle rounding, and the spread, may turn a joint's frame at most; 0 of the base."""
    turned = 0.0
    while joint >= 0:
        turned += 0.0 if steps[joint, SLIDES] > 0.0 else steps[joint, ASIDE]
        joint = int(joints[joint, PARENT])
    return turned


@kernel
def turn_of(steps, joint):
    """The greatest rate at which a joint's frame turns; 0 of the base."""
    return steps[joint, TURN] if joint >= 0 else 0.0


@kernel
def keep_shares(joints, keeps, slacks, moving, half, like):
    """The greatest share of a tolerance that is used at the middles of intervals, and a bound of it within ``half``.

    moving: where the joints are, and how they move (``ball_motion.write_twists``).
    """
    value, most, n = splat(0.0, like), splat(0.0, like), joints.shape[0]
    for i in range(keeps.allowed.shape[0]):
        allowed, frames = keeps.allowed[i], keeps.frames
        joint_a, joint_b, shared = int(frames[2 * i, JOINT]), int(frames[2 * i + 1, JOINT]), allowed.shared
        a, b = frame_pose(frames, 2 * i, moving.joint_rows, like), frame_pose(frames, 2 * i + 1, moving.joint_rows, like)
        v, w = joint_twist(moving, joint_a, origin(a), like)
        u, slack = transform_inverse(b, origin(a)), splat(slacks[i, 0], like)
        speed, curved = pair_bounds(joints, moving, 2 * i, 2 * i + 1, shared)
        rate, bend = splat(speed, like), splat(curved, like)
        turn, lost, lost_turn = turn_of(moving.steps, joint_a), 0.0, 0.0  # what rounding adds to the velocities
        if joint_b >= 0:
            v_b, w_b = joint_twist(moving, joint_b, origin(a), like)
            v, w = minus(v, v_b), minus(w, w_b)
            lost = ROUNDING * (moving.speeds[2 * i, n] + moving.speeds[2 * i + 1, n])
            lost_turn = ROUNDING * (turn + turn_of(moving.steps, joint_b))
            turned = turn_of(moving.steps, joint_b) - turn_of(moving.steps, shared)
            turn += turned - turn_of(moving.steps, shared)
            longest = (sqrt(dot(u, u)) + slack + speed * half) * (1.0 + ROUNDING)
            rate, bend = rate + turned * longest, bend + turned * (2.0 * speed + turned * longest)
            slack = slack + slacks[i, 2] * longest
        du = rotate_inverse(b, v)
        for k in range(3):
            if allowed.away[k] < _INF:
                now, share = abs(u[k]), 1.0 / allowed.away[k]
                moved = minimum(rate * half, half * (abs(du[k]) + lost) + (0.5 * bend) * half * half) * (1.0 + ROUNDING)
                value = maximum(value, (now + slack) * share)
                most = maximum(most, (now + moved + slack) * share)
        if allowed.axes != NO_AXIS:
            share = 1.0 / allowed.chord
            if allowed.axes == TOWARDS:
                now, far = direction_bounds(a, b, v, w, (turn, rate, bend, slack, lost), half)
            else:
                now, there = axis_differences(a, b, w, half, allowed.axes)
                scale = _ROOT_TWO if allowed.axes == ALL_AXES else 1.0
                far = minimum(now + (scale * turn) * half, there + (0.5 * scale * turn * turn) * half * half)
            value = maximum(value, (now + slacks[i, 1]) * share)
            most = maximum(most, ((far + (_ROOT_TWO * lost_turn) * half) * (1.0 + ROUNDING) + slacks[i, 1]) * share)
    return value, most


@kernel
def direction_bounds(a, b, v, w, bounds, half):
    """|x| of the z axis of a pose and the direction from its origin to that of another one, and a bound of it within ``half``.

    v, w: the velocity and the angular velocity of a as b sees them. bounds: of the turn, of |v| and of its derivative; how far
    a's origin may be from where it is computed, and what rounding adds to v. |x| is 2 at most.
    """
    turn, rate, bend, slack, lost = bounds
    d, z = minus(origin(b), origin(a)), z_axis(a)
    distance = sqrt(dot(d, d))
    near = 1.0 / maximum(distance, MIN_LENGTH)
    nearest = 1.0 / maximum(distance - half * rate - slack, MIN_LENGTH)
    g = scaled(d, near)
    xx, xd, dd = products(minus(z, g), minus(cross(w, z), cross(scaled(cross(v, g), near), g)))
    now, first, second = sqrt(xx), turn + rate * nearest, turn * turn + (bend + _BENT * rate * rate * nearest) * nearest
    there = sqrt(xx + half * (2.0 * abs(xd) + half * dd)) + half * (lost * near + 0.5 * half * second)
    far = minimum(now + first * half, there)
    return minimum(now + slack / maximum(distance - slack, MIN_LENGTH), 2.0), minimum(far + slack * nearest, 2.0)


@kernel
def axis_differences(a, b, w, half, axes):
    """|x| of two poses, and the greater of |x +- half x'|, where a turns with the angular velocity w."""
    xx, xd, dd = difference_products(z_axis(a), z_axis(b), w)
    if axes == ALL_AXES:
        x = difference_products(x_axis(a), x_axis(b), w)
        y = difference_products(y_axis(a), y_axis(b), w)
        xx, xd, dd = xx + x[0] + y[0], xd + x[1] + y[1], dd + x[2] + y[2]
    return sqrt(xx), sqrt(xx + half * (2.0 * abs(xd) + half * dd))


@kernel
def difference_products(a, b, w):
    """x . x, x . x' and x' . x' of the difference x = a - b, where a turns with the angular velocity w."""
    return products(minus(a, b), cross(w, a))


@kernel
def products(x, d):
    """x . x, x . d and d . d."""
    return dot(x, x), dot(x, d), dot(d, d)
