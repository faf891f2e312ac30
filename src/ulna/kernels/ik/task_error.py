"""Reduces a pose error and its Jacobian to the components of a task.

A component within its slack counts as zero, and beyond it only the excess over the slack counts (``task_error``). A pointing task
counts the *swing* alone: the smallest rotation that brings the z axis of the pose onto the z axis of the target.

Source: TRAC-IK (Beeson and Ames, Humanoids 2015), for the slacks.
"""

import math

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, sqrt, store, where
from ulna.kernels.spatial.elementary import first_quadrant_angle
from ulna.kernels.spatial.vectors import cross, rotate_inverse

_TINY = 1e-12  # of a sine: below it the axis of a half turn is chosen, not computed


@kernel
def task_error(is_pointing, slack, pose, target, e, jacobian_rows):
    """The error that the task counts, in the target's axes; the rows of J are rotated there too.

    slack: The tolerance of each of the six components [m, rad].

    1. Rotate e and the columns of J into the target's axes. For a pointing task, the rotation is the swing of the z axis alone.
    2. Subtract the slack from each component. A component within its slack counts as zero, and so does its row of J, so that it
       stays free.
    """
    w = swing(pose, target) if is_pointing else (e[3], e[4], e[5])
    v, w = rotate_inverse(target, (e[0], e[1], e[2])), rotate_inverse(target, w)
    c0, f0 = beyond(v[0], slack[0])
    c1, f1 = beyond(v[1], slack[1])
    c2, f2 = beyond(v[2], slack[2])
    c3, f3 = beyond(w[0], slack[3])
    c4, f4 = beyond(w[1], slack[4])
    c5, f5 = beyond(w[2], slack[5])
    for j in range(jacobian_rows.shape[0] // 6):
        v = load(jacobian_rows, 6 * j), load(jacobian_rows, 6 * j + 1), load(jacobian_rows, 6 * j + 2)
        w = load(jacobian_rows, 6 * j + 3), load(jacobian_rows, 6 * j + 4), load(jacobian_rows, 6 * j + 5)
        v, w = rotate_inverse(target, v), rotate_inverse(target, w)
        store(jacobian_rows, 6 * j, v[0] * f0)
        store(jacobian_rows, 6 * j + 1, v[1] * f1)
        store(jacobian_rows, 6 * j + 2, v[2] * f2)
        store(jacobian_rows, 6 * j + 3, w[0] * f3)
        store(jacobian_rows, 6 * j + 4, w[1] * f4)
        store(jacobian_rows, 6 * j + 5, w[2] * f5)
    return c0, c1, c2, c3, c4, c5


@kernel
def beyond(x, slack):
    """The excess of x over a slack on either side; and 0.0 if x stays free within it, else 1.0."""
    within = abs(x) <= slack
    rest = where(within, 0.0, where(x > 0.0, x - slack, x + slack))
    return rest, where(within, 0.0 if slack > 0.0 else 1.0, 1.0)


@kernel
def swing(pose, target):
    """The smallest rotation from pose's z axis to the target's, as a rotation vector in the base's axes.

    For opposite axes, it is a rotation by pi about the target's x axis.
    """
    a, b = (pose[2], pose[6], pose[10]), (target[2], target[6], target[10])
    n = cross(a, b)
    sine, cosine = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    acute = first_quadrant_angle(sine, abs(cosine))
    angle = where(cosine < 0.0, math.pi - acute, acute)
    opposite = (sine <= _TINY) & (cosine < 0.0)
    scale = where(sine > _TINY, angle / where(sine > _TINY, sine, 1.0), 1.0)
    return (
        where(opposite, angle * target[0], n[0] * scale),
        where(opposite, angle * target[4], n[1] * scale),
        where(opposite, angle * target[8], n[2] * scale),
    )
