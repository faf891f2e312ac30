"""Solves six revolute joints: a spherical wrist, two axes before it parallel or intersecting. Used by ``closed_form``.

The position of the wrist's centre gives the first three angles, then the rotation the others.

Source: Pieper (1968); Elias and Wen, IK-Geo (2022), section 5; Ostermeier, Kuelz and Althoff, EAIK (2024), for the families.
In vectors: p = R_1 (P_1 + R_2 (P_2 + R_3 P_3)), R_i = rot(h_i, q_i), with p from the point on the first axis to the centre.

1. One of the first three angles by one equation in it alone (``outer_angle``): two of them.
2. The other two (``inner_angles``): two pairs each.
3. R_3' R_2' R_1' R = R_4 R_5 R_6 gives q_5 by h_4 . (..) h_6, two of them, then q_4, and q_6 from the whole rotation: so it makes
   good what q_4 lacks at the wrist's singularity.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, near_behind, sure_behind
from ulna.kernels.chain.closed_form_layout import (
    AXES,
    BENDS,
    FAMILY,
    FORM,
    FREE_WRIST,
    INTERSECTING_12,
    NORMALS,
    PARALLEL_12,
    PARALLEL_23,
    POINTS,
)
from ulna.kernels.chain.closed_form_rows import free_angle, put, put_known, tabled
from ulna.kernels.chain.subproblems import (
    angle_onto,
    angle_to_direction,
    angle_to_plane,
    angle_to_sphere,
    reversed_vector,
    turn,
    turn_back,
)
from ulna.kernels.spatial.arc_tangent import full_circle_angle
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import dot, minus, plus, rotate


@kernel
def spherical_wrist(table, motion, p, sign_rows, n, free_rows, q_rows, known_rows):
    """Write all branches; the arguments are those of ``closed_form``, and p from the point on axis 1 to the wrist's centre."""
    h6, n6 = tabled(table, AXES + 5), tabled(table, NORMALS + 1)
    whole_axis, whole_normal = rotate(motion, h6), rotate(motion, n6)
    family = int(table[FORM, FAMILY])
    outer_first = family == PARALLEL_23 or family > PARALLEL_12
    for i in range(n):
        outer, v, sure_1, apart_1 = outer_angle(table, p, load(sign_rows, i), free_rows)
        q_outer = full_circle_angle(outer[0], outer[1])
        near_1, sure_1, apart_1 = accuracy(1.0, sure_1, apart_1, DOUBLE)
        for j in range(n):
            second, other, sure_2, apart_2, near = inner_angles(table, family, p, v, near_1, load(sign_rows, n + j), free_rows)
            q_second, q_other = full_circle_angle(second[0], second[1]), full_circle_angle(other[0], other[1])
            first, third, q_first, q_third = other, outer, q_other, q_outer
            if outer_first:
                first, third, q_first, q_third = outer, other, q_outer, q_other
            missed = position_square(table, p, first, second, third)
            axis = behind_arm(table, first, second, third, whole_axis)
            normal = behind_arm(table, first, second, third, whole_normal)
            sure, apart = minimum(sure_1, sure_2), minimum(apart_1, apart_2)
            for k in range(n):
                branch = (i * n + j) * n + k
                put(table, q_rows, branch, 0, q_first)
                put(table, q_rows, branch, 1, q_second)
                put(table, q_rows, branch, 2, q_third)
                sign = load(sign_rows, 2 * n + k)
                wrist(table, axis, normal, sign, free_rows, q_rows, known_rows, branch, missed, near, sure, apart)


@kernel
def wrist(table, axis, normal, sign, free_rows, q_rows, known_rows, branch, missed, near, sure, apart):
    """Step 3: write the last three angles and what is known of the branch; axis and normal are R_4 R_5 R_6 h_6 and n_6."""
    h4, h5, h6, n6 = tabled(table, AXES + 3), tabled(table, AXES + 4), tabled(table, AXES + 5), tabled(table, NORMALS + 1)
    bends, free = (table[BENDS, 0], table[BENDS, 1]), table[BENDS, FREE_WRIST]
    fifth, sure_5, apart_5 = angle_to_direction(h4, h6, h5, axis, bends, sign, free_angle(free_rows, 4))
    bent = turn(h5, fifth, h6)
    fourth, sure_4 = angle_onto(bent, axis, h4, free_angle(free_rows, 3))
    sixth, _ = angle_onto(n6, turn_back(h5, fifth, turn_back(h4, fourth, normal)), h6, free_angle(free_rows, 5))
    put(table, q_rows, branch, 3, full_circle_angle(fourth[0], fourth[1]))
    put(table, q_rows, branch, 4, full_circle_angle(fifth[0], fifth[1]))
    put(table, q_rows, branch, 5, full_circle_angle(sixth[0], sixth[1]))
    e = minus(turn(h4, fourth, bent), axis)
    f = minus(turn(h4, fourth, turn(h5, fifth, turn(h6, sixth, n6))), normal)
    _, sure_5, apart_5 = accuracy(near, sure_5, apart_5, DOUBLE)
    sure, apart = minimum(sure, maximum(minimum(sure_behind(near, sure_4), sure_5), free)), minimum(apart, maximum(apart_5, free))
    put_known(known_rows, branch, missed + dot(e, e) + dot(f, f), sure, apart)


@kernel
def behind_arm(table, first, second, third, v):
    """R_3' R_2' R_1' v."""
    v = turn_back(tabled(table, AXES + 1), second, turn_back(tabled(table, AXES), first, v))
    return turn_back(tabled(table, AXES + 2), third, v)


@kernel
def position_square(table, p, first, second, third):
    """|R_1' p - P_1 - R_2 (P_2 + R_3 P_3)|^2."""
    bent = plus(tabled(table, POINTS + 2), turn(tabled(table, AXES + 2), third, tabled(table, POINTS + 3)))
    e = minus(turn_back(tabled(table, AXES), first, p), tabled(table, POINTS + 1))
    e = minus(e, turn(tabled(table, AXES + 1), second, bent))
    return dot(e, e)


@kernel
def outer_angle(table, p, sign, free_rows):
    """Step 1: q_1 and R_1' p - P_1, or q_3 and P_2 + R_3 P_3; how well it is determined, and how far apart the two are."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    family = int(table[FORM, FAMILY])
    if family == PARALLEL_23:  # h_2 . R_1' p does not depend on q_2 and q_3
        d = dot(h2, plus(p1, plus(p2, p3)))
        angle, sure, apart = angle_to_plane(h2, p, reversed_vector(h1), d, sign, free_angle(free_rows, 0))
        v = minus(turn_back(h1, angle, p), p1)
    elif family == INTERSECTING_12:  # P_1 = 0: |p| = |P_2 + R_3 P_3|
        angle, sure, apart = angle_to_sphere(reversed_vector(p3), p2, h3, dot(p, p), sign, free_angle(free_rows, 2))
        v = plus(p2, turn(h3, angle, p3))
    elif family == PARALLEL_12:  # h_1 . p does not depend on q_1 and q_2
        d = dot(h1, minus(minus(p, p1), p2))
        angle, sure, apart = angle_to_plane(h1, p3, h3, d, sign, free_angle(free_rows, 2))
        v = plus(p2, turn(h3, angle, p3))
    else:  # P_2 = 0: |R_1' p - P_1| = |P_3|
        angle, sure, apart = angle_to_sphere(p, p1, reversed_vector(h1), dot(p3, p3), sign, free_angle(free_rows, 0))
        v = minus(turn_back(h1, angle, p), p1)
    return angle, v, sure, apart


@kernel
def inner_angles(table, family, p, v, near, sign, free_rows):
    """Step 2: q_2, and q_1 or q_3, from what step 1 returned; how well determined, how far apart; and ``near`` behind them."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    if family == PARALLEL_23:  # |v| = |P_2 + R_3 P_3|
        other, sure, apart = angle_to_sphere(reversed_vector(p3), p2, h3, dot(v, v), sign, free_angle(free_rows, 2))
        second, sure_2 = angle_onto(plus(p2, turn(h3, other, p3)), v, h2, free_angle(free_rows, 1))
    elif family == INTERSECTING_12:  # h_1 . p = h_1 . R_2 v
        second, sure, apart = angle_to_plane(h1, v, h2, dot(h1, p), sign, free_angle(free_rows, 1))
        other, sure_2 = angle_onto(turn(h2, second, v), p, h1, free_angle(free_rows, 0))
    elif family == PARALLEL_12:  # |p| = |P_1 + R_2 v|
        second, sure, apart = angle_to_sphere(reversed_vector(v), p1, h2, dot(p, p), sign, free_angle(free_rows, 1))
        other, sure_2 = angle_onto(plus(p1, turn(h2, second, v)), p, h1, free_angle(free_rows, 0))
    else:  # h_2 . v = h_2 . R_3 P_3
        other, sure, apart = angle_to_plane(h2, p3, h3, dot(h2, v), sign, free_angle(free_rows, 2))
        second, sure_2 = angle_onto(turn(h3, other, p3), v, h2, free_angle(free_rows, 1))
    near, sure, apart = accuracy(near, sure, apart, DOUBLE)
    return second, other, minimum(sure, sure_behind(near, sure_2)), apart, near_behind(near, sure_2)
