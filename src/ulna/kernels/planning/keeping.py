"""Bounds how far a frame of the robot gets from where it is to be kept, in an interval of an edge.

A constraint compares a frame of the robot with one of the base: the displacement u of its origin, in the axes of the other, and
the differences x of their z axes, or of all three axes in one vector. An angle theta between two axes, or of a rotation, makes

    |x| = 2 sin(theta / 2)    of one axis,        |x| = 2 sqrt(2) sin(theta / 2)    of three,

so a tolerance of the angle is one of |x|. On an edge, in an interval with middle c and half length h (Taylor, with a remainder
for vectors):

    |u_k| <= |u_k(c)| + h |u_k'(c)| + h^2 / 2 max |p''|,          max |p''| as in ``ball_motion``,
    |x|   <= max |x(c) +- h x'(c)| + h^2 / 2 s W^2,               s = 1 of one axis, sqrt(2) of three.

W is the sum of |r_i| of the joints that carry the frame and turn. An axis is a product of rotations by the joints' angles and of
constant ones, so its second derivative is a sum over pairs of joints of r_i r_k times a vector of length 1 at most; of three axes
one of Frobenius norm sqrt(2), that of the generator of a rotation. The first derivatives are bounded by the greatest speed of a
point, and by s W; the smaller of both bounds is taken. What rounding, and the spread beside the edge, may add is part of the
value.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, sqrt
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.collision.ball_motion import ROUNDING, joint_twist, offset_length, write_bounds
from ulna.kernels.collision.collision_layout import ASIDE, SLIDES, TURN
from ulna.kernels.layout import JOINT, PARENT
from ulna.kernels.planning.planning_layout import ALL_AXES, AWAY, AXES, CHORD, KEEP_ROWS, LEVER, NO_AXIS, REFERENCE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import constant_pose
from ulna.kernels.spatial.vectors import cross, dot, minus, origin, rotate_inverse, transform_inverse, x_axis, y_axis, z_axis

_INF, _ROOT_TWO = float("inf"), 1.4142135623730951  # sqrt(2)


@kernel
def write_keep_bounds(joints, keeps, steps, speeds, bends, slacks):
    """Write how fast the origin of each constraint's frame can move, and what rounding and the spread add to u and to x.

    speeds, bends: (n, n_joints + 1), as of balls; slacks: (n, 2).
    """
    for i in range(keeps.shape[0] // KEEP_ROWS):
        row, turned = KEEP_ROWS * i, 0.0
        joint = int(keeps[row, JOINT])
        far = ROUNDING * offset_length(keeps, row + REFERENCE)
        slacks[i, 0] = write_bounds(joints, steps, joint, keeps[row, LEVER], speeds, bends, i) + far
        while joint >= 0:
            turned += 0.0 if steps[joint, SLIDES] > 0.0 else steps[joint, ASIDE]
            joint = int(joints[joint, PARENT])
        slacks[i, 1] = _ROOT_TWO * (turned + ROUNDING)


@kernel
def keep_shares(keeps, speeds, bends, slacks, moving, half, like):
    """The greatest share of a tolerance that is used at the middles of intervals, and a bound of it within ``half``.

    moving: where the joints are, and how they move (``ball_motion.write_twists``).
    """
    value, most, n = splat(0.0, like), splat(0.0, like), speeds.shape[1] - 1
    for i in range(keeps.shape[0] // KEEP_ROWS):
        row = KEEP_ROWS * i
        joint, axes = int(keeps[row, JOINT]), int(keeps[row, AXES])
        a, b = frame_pose(keeps, row, moving.joint_rows, like), constant_pose(keeps, row + REFERENCE, like)
        v, w = joint_twist(moving, joint, origin(a), like)
        u, du = transform_inverse(b, origin(a)), rotate_inverse(b, v)
        by_speed, bend = speeds[i, n] * half, (0.5 * bends[i, n]) * half * half
        for k in range(3):
            if keeps[row, AWAY + k] < _INF:
                now, share = abs(u[k]), 1.0 / keeps[row, AWAY + k]
                moved = minimum(by_speed, half * abs(du[k]) + bend) * (1.0 + ROUNDING)
                value = maximum(value, (now + slacks[i, 0]) * share)
                most = maximum(most, (now + moved + slacks[i, 0]) * share)
        if axes != NO_AXIS:
            now, there = axis_differences(a, b, w, half, axes)
            scale, share = _ROOT_TWO if axes == ALL_AXES else 1.0, 1.0 / keeps[row, CHORD]
            turn = moving.steps[joint, TURN]
            far = minimum(now + (scale * turn) * half, there + (0.5 * scale * turn * turn) * half * half) * (1.0 + ROUNDING)
            value = maximum(value, (now + slacks[i, 1]) * share)
            most = maximum(most, (far + slacks[i, 1]) * share)
    return value, most


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
    x, d = minus(a, b), cross(w, a)
    return dot(x, x), dot(x, d), dot(d, d)
