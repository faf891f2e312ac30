"""Solves arms with a spherical wrist and one, two or three prismatic joints among the first three.

The position of the wrist's center is p = M_1 (P_1 + M_2 (P_2 + M_3 P_3)). M_i v is R_i v for a revolute joint, and v + d_i h_i
for a prismatic one. This equation gives the first three joints; the rotation gives the others, as in ``spherical_wrist``.

1. One prismatic joint before or behind two parallel axes: along these only the prismatic joint moves p, so its position is linear
   in p.
2. One prismatic joint before or behind two intersecting axes: it brings one point to a given distance from another, at two
   positions. ``spherical_wrist.inner_angles`` gives the two remaining angles.
3. Two prismatic joints and a revolute one: the prismatic joints move p in a plane, and the rotation brings it there, at two
   angles (subproblem 4).
4. Three prismatic joints: linear equations.

If an equation is linear, the sign that chooses among its solutions must be 1.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, sqrt, where
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, base_conditioning, compared_determination, next_conditioning
from ulna.kernels.chain.branch_records import Accuracy
from ulna.kernels.chain.closed_form_layout import (
    AXES,
    FAMILY,
    FORM,
    INTERSECTING_12,
    INTERSECTING_12_SLIDE,
    INTERSECTING_23,
    PARALLEL_12,
    PARALLEL_12_SLIDE,
    PARALLEL_23,
    POINTS,
    SLIDE_INTERSECTING_23,
    SLIDE_PARALLEL_23,
    SLIDES_TURN,
    TURN_SLIDES,
)
from ulna.kernels.chain.closed_form_rows import end_frame, free_angle, tabled
from ulna.kernels.chain.spherical_wrist import inner_angles, other_angle, wrist, wrist_matrix
from ulna.kernels.chain.subproblems import angles_to_plane, one_of_two, reversed_vector, turn, turn_back
from ulna.kernels.spatial.elementary import full_circle_angle, maximum, minimum
from ulna.kernels.spatial.vectors import add_scaled, cross, dot, minus, plus


@kernel
def sliding_arm(table, motion, p, branches):
    """Write all branches.

    motion: G of ``closed_form``. p: The vector from the point on joint 1 to the wrist's center.
    """
    last, sign_rows, n, free_rows = end_frame(table, motion), branches.sign_rows, branches.n, branches.free_rows
    for i in range(n):
        for j in range(n):
            joints, residual_square, determination, separation, conditioning = first_joints(
                table, p, load(sign_rows, i), load(sign_rows, n + j), free_rows
            )
            first, second, third = joints
            separation = where(residual_square > 0.0, -1.0, separation)  # if a sign has no choice, its second branch is invalid
            residual_square = residual_square + position_square(table, p, first, second, third)
            whole, row = wrist_matrix(table, first[:2], second[:2], third[:2], last), (i * n + j) * n
            angles = joint_value(first), joint_value(second), joint_value(third)
            wrist(table, whole, angles, row, branches, Accuracy(residual_square, conditioning, determination, separation))


@kernel
def joint_value(joint):
    """The angle or the length of a joint."""
    return full_circle_angle(joint[0], joint[1]) + joint[2]


@kernel
def revolute_joint(angle, like):
    """A revolute joint: the sine and cosine of its angle, and the length 0."""
    return angle[0], angle[1], 0.0 * like


@kernel
def prismatic_joint(way):
    """A prismatic joint: the sine and cosine of the angle 0, and its length."""
    return 0.0 * way, 0.0 * way + 1.0, way


@kernel
def apply_joint(h, joint, v):
    """M v."""
    return add_scaled(turn(h, (joint[0], joint[1]), v), joint[2], h)


@kernel
def position_square(table, p, first, second, third):
    """The squared error of p by the joints."""
    v = plus(tabled(table, POINTS + 2), apply_joint(tabled(table, AXES + 2), third, tabled(table, POINTS + 3)))
    v = plus(tabled(table, POINTS + 1), apply_joint(tabled(table, AXES + 1), second, v))
    e = minus(apply_joint(tabled(table, AXES), first, v), p)
    return dot(e, e)


@kernel
def length_to_sphere(u, h, square, sign):
    """One of the two lengths for which |u + way h|^2 is ``square``; and the discriminant."""
    b = dot(u, h)
    discriminant = b * b - dot(u, u) + square
    return sign * sqrt(maximum(discriminant, 0.0)) - b, discriminant


@kernel
def lengths_in_plane(w, h, k):
    """The lengths a and b for which a h + b k is nearest to w."""
    n = cross(h, k)
    r = 1.0 / dot(n, n)
    return dot(n, cross(w, k)) * r, dot(n, cross(h, w)) * r


@kernel
def inner_pair(table, family, p, v, conditioning, sign, free_rows):
    """The two angles of ``spherical_wrist.inner_angles`` and ``other_angle``, their accuracy, and ``conditioning`` after them.

    The accuracy is the determination and the distance of the roots.
    """
    both, determination, separation = inner_angles(table, family, p, v, free_rows)
    inner = one_of_two(both, sign)
    other, size = other_angle(table, family, p, v, inner, free_rows)
    conditioning, determination, separation = accuracy(conditioning, determination, separation, DOUBLE)
    return (
        inner,
        other,
        minimum(determination, compared_determination(conditioning, size)),
        separation,
        next_conditioning(conditioning, size),
    )


@kernel
def first_joints(table, p, sign_1, sign_2, free_rows):
    """Steps 1 to 4: three joints; an error if a sign has no choice; determination; root distance; ``conditioning``.

    ``conditioning`` is that after the three joints (``accuracy``).
    """
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    family, one = int(table[FORM, FAMILY]), 0.0 * p[0] + 1.0
    p23 = plus(p2, p3)
    p123 = plus(p1, p23)
    if family in (SLIDE_PARALLEL_23, SLIDE_INTERSECTING_23):
        u, separation, residual_square = minus(p, p1), one, where(sign_1 > 0.0, 0.0, one)
        way = (dot(h2, p) - dot(h2, p123)) / dot(h2, h1)
        inner = PARALLEL_23
        if family == SLIDE_INTERSECTING_23:
            way, separation = length_to_sphere(u, reversed_vector(h1), dot(p3, p3), sign_1)
            residual_square, inner = 0.0 * one, INTERSECTING_23
        conditioning, _, separation = accuracy(base_conditioning(table), one, separation, DOUBLE)
        third, second, determination, separation_2, conditioning = inner_pair(
            table, inner, p, add_scaled(u, -way, h1), conditioning, sign_2, free_rows
        )
        return (
            (prismatic_joint(way), revolute_joint(second, one), revolute_joint(third, one)),
            residual_square,
            determination,
            minimum(separation, separation_2),
            conditioning,
        )
    if family in (INTERSECTING_12_SLIDE, PARALLEL_12_SLIDE):
        separation, residual_square = one, where(sign_1 > 0.0, 0.0, one)
        way = (dot(h1, p) - dot(h1, p123)) / dot(h1, h3)
        inner = PARALLEL_12
        if family == INTERSECTING_12_SLIDE:
            way, separation = length_to_sphere(p23, h3, dot(p, p), sign_1)
            residual_square, inner = 0.0 * one, INTERSECTING_12
        conditioning, _, separation = accuracy(base_conditioning(table), one, separation, DOUBLE)
        second, first, determination, separation_2, conditioning = inner_pair(
            table, inner, p, add_scaled(p23, way, h3), conditioning, sign_2, free_rows
        )
        return (
            (revolute_joint(first, one), revolute_joint(second, one), prismatic_joint(way)),
            residual_square,
            determination,
            minimum(separation, separation_2),
            conditioning,
        )
    residual_square = where(sign_2 > 0.0, 0.0, one)
    if family == TURN_SLIDES:
        n = cross(h2, h3)
        firsts, determination, separation = angles_to_plane(n, p, reversed_vector(h1), dot(n, p123), free_angle(free_rows, 0))
        first = one_of_two(firsts, sign_1)
        way_2, way_3 = lengths_in_plane(minus(turn_back(h1, first, p), p123), h2, h3)
        conditioning, determination, separation = accuracy(base_conditioning(table), determination, separation, DOUBLE)
        return (
            (revolute_joint(first, one), prismatic_joint(way_2), prismatic_joint(way_3)),
            residual_square,
            determination,
            separation,
            conditioning,
        )
    if family == SLIDES_TURN:
        n, w = cross(h1, h2), minus(minus(p, p1), p2)
        thirds, determination, separation = angles_to_plane(n, p3, h3, dot(n, w), free_angle(free_rows, 2))
        third = one_of_two(thirds, sign_1)
        way_1, way_2 = lengths_in_plane(minus(w, turn(h3, third, p3)), h1, h2)
        conditioning, determination, separation = accuracy(base_conditioning(table), determination, separation, DOUBLE)
        return (
            (prismatic_joint(way_1), prismatic_joint(way_2), revolute_joint(third, one)),
            residual_square,
            determination,
            separation,
            conditioning,
        )
    w, n = minus(p, p123), cross(h2, h3)
    r = 1.0 / dot(h1, n)
    ways = dot(w, n) * r, dot(h1, cross(w, h3)) * r, dot(h1, cross(h2, w)) * r
    residual_square = residual_square + where(sign_1 > 0.0, 0.0, one)
    return (
        (prismatic_joint(ways[0]), prismatic_joint(ways[1]), prismatic_joint(ways[2])),
        residual_square,
        one,
        one,
        base_conditioning(table) * one,
    )
