"""Bounds the deviation of a frame of the robot from its constraint, in an interval of an edge.

A constraint compares a frame a of the robot with another frame b, of the base or of the robot. Let u be the displacement of a's
origin in the axes of b. Let x be the difference of their z axes, or of all three axes in one vector. For an angle theta between
two axes, or of a rotation,

    |x| = 2 sin(theta / 2)    for one axis,        |x| = 2 sqrt(2) sin(theta / 2)    for three axes,

so a tolerance of the angle gives a tolerance of |x|. Consider an interval of an edge with middle c and half-length h. Taylor's
formula, with a remainder for vectors, gives for the motion relative to b

    |u_k| <= |u_k(c)| + h |u_k'(c)| + h^2 / 2 max |u''|,
    |x|   <= max |x(c) +- h x'(c)| + h^2 / 2 s W^2,               s = 1 for one axis, sqrt(2) for three axes.

r_i is the rate of joint i along the edge. W is the sum of |r_i| over the revolute joints between a and b. Joints that carry both
do not change the relative motion. An axis is a product of rotations by the joints' angles and of constant rotations. So its
second derivative is a sum over pairs of joints of r_i r_k times a vector of length 1 at most. For three axes this vector has the
Frobenius norm sqrt(2), the norm of the generator of a rotation. The first derivatives are bounded by the maximum speed of a point
and by s W; the smaller bound is used. The values include bounds of rounding and of the spread beside the edge.

Relative to the joint that carries both frames, or to the base, let d be the vector from b to a. It changes with |d'| <= S and
|d''| <= B (``ball_motion.pair_bounds``), so its length is at most D = |u(c)| + h S. The axes of b turn with at most W_b, and u_k
is the product of d and such an axis. Hence, by the product rule,

    |u'| <= S + W_b D,        |u''| <= B + 2 W_b S + W_b^2 D.

If an axis points at b's origin, x is its difference from the direction g = -u / |u|. While |u| >= m,

    |g'| <= |u'| / m,        |g''| <= |u''| / m + 2 / sqrt(3) |u'|^2 / m^2.

The proof: u' has a component p along g, and a component n perpendicular to g. g'' is the sum of a part of u'' / |u| and of two
terms. The first is 2 p n / |u|^2, perpendicular to g, and the second n^2 / |u|^2, along g. With p^2 + n^2 = |u'|^2 the two
together are at most 2 / sqrt(3) |u'|^2 / |u|^2.
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
    """Write bounds of the speeds of each constraint's two frames, and the additions for rounding and the spread.

    moving: its speeds and bends have two rows per constraint, for its frame and the other frame. slacks: shape (n, 3): additions
    to the displacement and to the difference of axes, and the largest rotation of the other frame's axes.
    """
    for i in range(keeps.allowed.shape[0]):
        a, b = 2 * i, 2 * i + 1
        joint_a, joint_b = int(keeps.frames[a, JOINT]), int(keeps.frames[b, JOINT])
        aside = write_bounds(joints, moving.steps, joint_a, keeps.allowed[i].lever, moving.speeds, moving.bends, a)
        far = write_bounds(joints, moving.steps, joint_b, offset_length(keeps.frames, b), moving.speeds, moving.bends, b)
        slacks[i, 0], slacks[i, 2] = aside + far, max_rotation_error(joints, moving.steps, joint_b)
        slacks[i, 1] = _ROOT_TWO * (max_rotation_error(joints, moving.steps, joint_a) + slacks[i, 2] + ROUNDING)


@kernel
def max_rotation_error(joints, steps, joint):
    """The largest rotation of a joint's frame by rounding and the spread [rad]; 0 for the base."""
    turned = 0.0
    while joint >= 0:
        turned += 0.0 if steps[joint, SLIDES] > 0.0 else steps[joint, ASIDE]
        joint = int(joints[joint, PARENT])
    return turned


@kernel
def max_rotation_rate(steps, joint):
    """The maximum rate of rotation of a joint's frame; 0 for the base."""
    return steps[joint, TURN] if joint >= 0 else 0.0


@kernel
def keep_shares(joints, keeps, slacks, moving, half, like):
    """The largest used share of a tolerance at the middles of intervals, and an upper bound within ``half``.

    moving: the poses and twists of the joints (``ball_motion.write_twists``).
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
        turn, lost, lost_turn = max_rotation_rate(moving.steps, joint_a), 0.0, 0.0  # lost: rounding of the velocities
        if joint_b >= 0:
            v_b, w_b = joint_twist(moving, joint_b, origin(a), like)
            v, w = minus(v, v_b), minus(w, w_b)
            lost = ROUNDING * (moving.speeds[2 * i, n] + moving.speeds[2 * i + 1, n])
            lost_turn = ROUNDING * (turn + max_rotation_rate(moving.steps, joint_b))
            turned = max_rotation_rate(moving.steps, joint_b) - max_rotation_rate(moving.steps, shared)
            turn += turned - max_rotation_rate(moving.steps, shared)
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
    """The deviation |x| of a's z axis from the direction to b's origin, and an upper bound within ``half``.

    v, w: the velocity and the angular velocity of a relative to b. bounds: of the rotation rate, of |v| and of its derivative; of
    the rounding of a's origin, and of v. |x| is 2 at most.
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
    """The norm |x| of the difference of two poses' axes, and the larger of |x +- half x'|.

    w: the angular velocity of a.
    """
    xx, xd, dd = difference_products(z_axis(a), z_axis(b), w)
    if axes == ALL_AXES:
        x = difference_products(x_axis(a), x_axis(b), w)
        y = difference_products(y_axis(a), y_axis(b), w)
        xx, xd, dd = xx + x[0] + y[0], xd + x[1] + y[1], dd + x[2] + y[2]
    return sqrt(xx), sqrt(xx + half * (2.0 * abs(xd) + half * dd))


@kernel
def difference_products(a, b, w):
    """The inner products xx, xx' and x'x' of x = a - b, with the angular velocity w of a."""
    return products(minus(a, b), cross(w, a))


@kernel
def products(x, d):
    """The products x . x, x . d and d . d."""
    return dot(x, x), dot(x, d), dot(d, d)
