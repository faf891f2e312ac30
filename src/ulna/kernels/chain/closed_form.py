"""Computes all branches of inverse kinematics of six joints in closed form.

1. Convert the target T to the motion G = T T(0)^-1 of the end, with an exact rotation and lengths as shares of the reach. If the
   chain is seen from its end, invert G.
2. Compute the angles of each branch of the family (``three_parallel``, ``parallel_wrist``, ``spherical_wrist``, ``quartic_arm``,
   ``sliding_arm``), and the residual. For the residual, the forward kinematics from the base on and back from the target are
   compared where they meet. Both use the branch's sines and cosines.
"""

from ulna.engine.decorators import kernel, shared_routine
from ulna.engine.lanes import any_lane
from ulna.kernels.chain.branch_records import Branches
from ulna.kernels.chain.closed_form_layout import (
    ANY_THREE_AXES,
    FAMILY,
    FORM,
    FRAME,
    INTERSECTING_23,
    INVERSE_REACH,
    LAST,
    OFFSET_HAND,
    PARALLEL_23,
    POINTS,
    REVERSED,
    THREE_PARALLEL,
)
from ulna.kernels.chain.closed_form_rows import tabled
from ulna.kernels.chain.parallel_links import parallel_wrist
from ulna.kernels.chain.quartic_arm import any_three_axes, offset_hand
from ulna.kernels.chain.sliding_arm import sliding_arm
from ulna.kernels.chain.spherical_wrist import spherical_wrist
from ulna.kernels.chain.three_parallel import three_parallel
from ulna.kernels.spatial.se3 import compose, load_pose
from ulna.kernels.spatial.vectors import chosen, dot, minus, origin, plus, rotate, x_axis, y_axis, z_axis

_ONCE = 1e-17  # of the square of the error: one step leaves only rounding


@shared_routine
def closed_form(table, target_rows, sign_rows, n, free_rows, q_rows, known_rows):
    """Steps 1 and 2.

    A branch is chosen by three signs, each with its own n choices. With n = 2, lanes are targets, the signs are 1 and -1 in all
    lanes, and eight branches are written. With n = 1, lanes are the eight branches of one target, and each lane writes one.

    table: ``closed_form_layout``. target_rows: A pose, twelve rows. sign_rows: 3 n rows. free_rows: Twelve rows, sines and
    cosines of the values for undetermined angles. q_rows: Six rows a branch, output. known_rows: Residual and accuracy, N_KNOWN
    rows a branch, output.
    """
    motion, branches = end_motion(table, load_pose(target_rows, 0)), Branches(sign_rows, n, free_rows, q_rows, known_rows)
    p = minus(plus(origin(motion), rotate(motion, tabled(table, LAST))), tabled(table, POINTS))
    if int(table[FORM, FAMILY]) == THREE_PARALLEL:
        three_parallel(table, motion, p, branches)
    elif int(table[FORM, FAMILY]) == PARALLEL_23:
        parallel_wrist(table, motion, p, branches)
    elif int(table[FORM, FAMILY]) == OFFSET_HAND:
        offset_hand(table, motion, p, branches)
    elif int(table[FORM, FAMILY]) == ANY_THREE_AXES:
        any_three_axes(table, motion, p, branches)
    elif int(table[FORM, FAMILY]) > INTERSECTING_23:
        sliding_arm(table, motion, p, branches)
    else:
        spherical_wrist(table, motion, p, branches)


@kernel
def end_motion(table, target):
    """Step 1: G, a pose."""
    share = table[FORM, INVERSE_REACH]
    x, y, z, o = tabled(table, FRAME), tabled(table, FRAME + 1), tabled(table, FRAME + 2), tabled(table, FRAME + 3)
    frame = x[0], y[0], z[0], o[0], x[1], y[1], z[1], o[1], x[2], y[2], z[2], o[2]
    a = make_rigid(target)
    a = a[0], a[1], a[2], a[3] * share, a[4], a[5], a[6], a[7] * share, a[8], a[9], a[10], a[11] * share
    a = compose(a, frame)
    if table[FORM, REVERSED] != 0.0:
        return inverted(a)
    return a


@kernel
def inverted(a):
    """The inverse of a pose."""
    return (
        a[0], a[4], a[8], -(a[0] * a[3] + a[4] * a[7] + a[8] * a[11]),
        a[1], a[5], a[9], -(a[1] * a[3] + a[5] * a[7] + a[9] * a[11]),
        a[2], a[6], a[10], -(a[2] * a[3] + a[6] * a[7] + a[10] * a[11]),
    )  # fmt: skip


@kernel
def make_rigid(a):
    """A pose whose rotation is exact up to rounding; the given rotation has an error of at most LARGEST_DEFECT."""
    b, square = nearer_rotation(a)
    is_far = square > _ONCE
    if any_lane(is_far):
        c, _ = nearer_rotation(b)
        x, y, z = chosen(is_far, x_axis(c), x_axis(b)), chosen(is_far, y_axis(c), y_axis(b)), chosen(is_far, z_axis(c), z_axis(b))
        return x[0], y[0], z[0], a[3], x[1], y[1], z[1], a[7], x[2], y[2], z[2], a[11]
    return b


@kernel
def nearer_rotation(a):
    """A pose with a more exact rotation ``R (3 I - R'R) / 2``, and the squared error of R.

    The new rotation's error is the square of the old one's (Bjorck and Bowie 1971).
    """
    x, y, z = (a[0], a[4], a[8]), (a[1], a[5], a[9]), (a[2], a[6], a[10])
    xy, yz, zx = -0.5 * dot(x, y), -0.5 * dot(y, z), -0.5 * dot(z, x)
    of_x, of_y, of_z = 0.5 - 0.5 * dot(x, x), 0.5 - 0.5 * dot(y, y), 0.5 - 0.5 * dot(z, z)
    xx, yy, zz = 1.0 + of_x, 1.0 + of_y, 1.0 + of_z
    square = of_x * of_x + of_y * of_y + of_z * of_z + xy * xy + yz * yz + zx * zx
    b = (
        x[0] * xx + y[0] * xy + z[0] * zx, x[0] * xy + y[0] * yy + z[0] * yz, x[0] * zx + y[0] * yz + z[0] * zz, a[3],
        x[1] * xx + y[1] * xy + z[1] * zx, x[1] * xy + y[1] * yy + z[1] * yz, x[1] * zx + y[1] * yz + z[1] * zz, a[7],
        x[2] * xx + y[2] * xy + z[2] * zx, x[2] * xy + y[2] * yy + z[2] * yz, x[2] * zx + y[2] * yz + z[2] * zz, a[11],
    )  # fmt: skip
    return b, square
