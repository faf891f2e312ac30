"""Solves the Paden-Kahan subproblems, in least squares if they have no solution.

Each solves for one angle of a rotation. An angle is a pair, its sine and cosine. ``rot(k, angle)`` is the rotation about the unit
vector k.

Source: Elias and Wen, IK-Geo: unified robot inverse kinematics using subproblem decomposition (2022), section 3: subproblems 1, 3
and 4, with their least-squares solutions. Their subproblem 2 is 4 followed by 1. Paden (1986), Kahan (1983).
"""

import math

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt, where
from ulna.kernels.chain.closed_form_layout import UNDETERMINED
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.vectors import cross, dot


@kernel
def turn(k, angle, v):
    """rot(k, angle) v, by Rodrigues' formula."""
    s, c = angle
    w = cross(k, v)
    along = dot(k, v) * (1.0 - c)
    return v[0] * c + w[0] * s + k[0] * along, v[1] * c + w[1] * s + k[1] * along, v[2] * c + w[2] * s + k[2] * along


@kernel
def turn_back(k, angle, v):
    """rot(k, -angle) v."""
    return turn(k, (-angle[0], angle[1]), v)


@kernel
def reversed_vector(v):
    """-v."""
    return -v[0], -v[1], -v[2]


@kernel
def subtracted(angle_a, angle_b):
    """The difference of two angles."""
    return angle_a[0] * angle_b[1] - angle_a[1] * angle_b[0], angle_a[1] * angle_b[1] + angle_a[0] * angle_b[0]


@kernel
def chosen_angle(mask, angle_a, angle_b):
    """One angle where the mask is true, the other elsewhere."""
    return where(mask, angle_a[0], angle_b[0]), where(mask, angle_a[1], angle_b[1])


@kernel
def wrapped(x):
    """An angle of at most 3 pi in size, wrapped to [-pi, pi]."""
    x = where(x > math.pi, x - 2.0 * math.pi, x)
    return where(x < -math.pi, x + 2.0 * math.pi, x)


@kernel
def one_of_two(both, sign):
    """One of two angles, by the sign.

    ``both`` is the mean of their sines and cosines, and the difference of the first from the mean.
    """
    middle, way = both
    return middle[0] + sign * way[0], middle[1] + sign * way[1]


@kernel
def unit_angle(s, c, free):
    """The angle of (s, c), or ``free`` if both are 0; and s^2 + c^2."""
    size = s * s + c * c
    good = size > UNDETERMINED
    r = 1.0 / sqrt(where(good, size, 1.0))
    return (where(good, s * r, free[0]), where(good, c * r, free[1])), size


@kernel
def angle_onto(p, q, k, free):
    """Subproblem 1: the angle with rot(k, angle) p nearest to q, or ``free`` for points on the axis.

    Sine and cosine are those between k x p and k x q: between p and q themselves they would lose half their digits near the axis.

    Returns the angle and the square of the product of the distances of p and q from the axis.
    """
    across_p, across_q = cross(k, p), cross(k, q)
    return unit_angle(dot(across_p, cross(across_q, k)), dot(across_p, across_q), free)


@kernel
def angle_onto_in_frame(p, q, free):
    """``angle_onto`` for p and q in the frame of the axis (``closed_form_rows``)."""
    return unit_angle(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1], free)


@kernel
def angles_to_plane(h, p, k, d, free):
    """Subproblem 4: both angles with ``h . rot(k, angle) p = d`` (``one_of_two``), or ``free`` if any will do.

    1. h . rot(k, angle) p = h.k k.p + a_s sin(angle) + a_c cos(angle). Let b = d - h.k k.p and a = |(a_s, a_c)|. The solutions
    are the angle of (a_s, a_c) plus or minus the angle with the cosine b / a. 2. If the discriminant a^2 - b^2 is negative there
    is no solution. The nearest angle is that of (a_s, a_c), or its opposite.

    Returns the angles, their determination (a^4), and the discriminant as a share of a^2.
    """
    hk_kp = dot(h, k) * dot(k, p)
    a_s, a_c = dot(h, cross(k, p)), dot(h, p) - hk_kp
    b = d - hk_kp
    return angles_of_two(a_s, a_c, b, a_s * a_s + a_c * a_c - b * b, free)


@kernel
def angles_of_two(a_s, a_c, b, discriminant, free):
    """Step 2 of subproblem 4."""
    real = maximum(discriminant, 0.0)
    size = (a_s * a_s + a_c * a_c) * (b * b + real)  # a^4 if there is a solution
    good = size > UNDETERMINED
    r = 1.0 / sqrt(where(good, size, 1.0))
    share, half = b * r, sqrt(real) * r
    middle = where(good, a_s * share, free[0]), where(good, a_c * share, free[1])
    way = where(good, a_c * half, 0.0), where(good, -a_s * half, 0.0)
    return (middle, way), size, where(good, discriminant * r, 1.0)  # r is 1 / a^2 if there is a solution


@kernel
def angles_to_sphere(p, q, k, square, free):
    """Subproblem 3: both angles for which |rot(k, angle) p - q|^2 is ``square``, in the form of ``angles_to_plane``."""
    return angles_to_plane(q, p, k, 0.5 * (dot(p, p) + dot(q, q) - square), free)


@kernel
def angles_to_sphere_in_frame(p, q, square, free):
    """``angles_to_sphere`` in the frame of the axis (``closed_form_rows``), for the components of p and q normal to it."""
    a_s, a_c = q[1] * p[0] - q[0] * p[1], q[0] * p[0] + q[1] * p[1]
    b = 0.5 * (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1] - square)
    return angles_of_two(a_s, a_c, b, a_s * a_s + a_c * a_c - b * b, free)


@kernel
def angles_to_direction(h, p, k, v, bends, free):
    """Subproblem 4 for unit vectors, returned as by ``angles_to_plane``: ``d = h . v``, v in the frame of h.

    If h and v are nearly parallel, as at the singularity of a wrist, b as a cosine loses half its digits. So the discriminant is
    ``(1 - h.v - bends[0]) (1 + h.v - bends[1])``; 1 - h.v = |h - v|^2 / 2; 1 + h.v = |h + v|^2 / 2. With the angles a and b of k
    with h and p, bends = 1 - cos(a - b), 1 + cos(a + b).
    """
    hk_kp = dot(h, k) * dot(k, p)
    a_s, a_c = dot(h, cross(k, p)), dot(h, p) - hk_kp
    across, less, more = v[0] * v[0] + v[1] * v[1], 1.0 - v[2], 1.0 + v[2]
    discriminant = (0.5 * (across + less * less) - bends[0]) * (0.5 * (across + more * more) - bends[1])
    return angles_of_two(a_s, a_c, v[2] - hk_kp, discriminant, free)
