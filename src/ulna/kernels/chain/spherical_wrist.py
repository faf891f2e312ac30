"""Solves six revolute joints: a spherical wrist, with two parallel or intersecting axes before it.

The position of the wrist's center gives the first three angles, then the rotation gives the others. In vectors: p = R_1 (P_1 +
R_2 (P_2 + R_3 P_3)); R_i = rot(h_i, q_i); p is the vector from the point on the first axis to the center.

1. One equation gives one of the first three angles alone (``outer_angle``), with two solutions.
2. The other two follow (``inner_angles``), with two solutions each.
3. R_3' R_2' R_1' R = R_4 R_5 R_6 gives q_5 by h_4 . (..) h_6, with two solutions, then q_4. q_6 comes from the whole rotation, so
   it compensates the error of q_4 at the wrist's singularity. The rotation is the matrix W = F_4' R_3' R_2' R_1' R F_6 in the
   frames of axes 4 and 6.

If axes 2 and 3 are parallel behind a first revolute one, steps 1 and 2 are in the frame of axis 2 (``parallel_wrist``).

Source: Pieper (1968); Elias and Wen, IK-Geo (2022), section 5; Ostermeier, Kuelz and Althoff, EAIK (2024), for the families.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load
from ulna.kernels.chain.accuracy import (
    DOUBLE,
    accuracy,
    base_conditioning,
    compared_determination,
    next_conditioning,
    worse_separation,
)
from ulna.kernels.chain.branch_records import Accuracy
from ulna.kernels.chain.closed_form_layout import (
    AXES,
    BENDS,
    FAMILY,
    FORM,
    FREE_WRIST,
    INTERSECTING_12,
    NORMALS,
    OF_4,
    PARALLEL_12,
    PARALLEL_23,
    POINTS,
)
from ulna.kernels.chain.closed_form_rows import (
    by_columns,
    column,
    end_frame,
    fifth_turn,
    free_angle,
    rotate_back_in_frame,
    rotate_in_frame,
    store_angle,
    store_properties,
    tabled,
)
from ulna.kernels.chain.subproblems import (
    angle_onto,
    angle_onto_in_frame,
    angles_to_direction,
    angles_to_plane,
    angles_to_sphere,
    one_of_two,
    reversed_vector,
    turn,
    turn_back,
    unit_angle,
)
from ulna.kernels.spatial.elementary import full_circle_angle, maximum, minimum
from ulna.kernels.spatial.vectors import cross, dot, minus, plus, transposed_times


@kernel
def spherical_wrist(table, motion, p, branches):
    """Write all branches.

    motion: G of ``closed_form``. p: The vector from the point on axis 1 to the wrist's center.
    """
    sign_rows, n, free_rows = branches.sign_rows, branches.n, branches.free_rows
    family, last = int(table[FORM, FAMILY]), end_frame(table, motion)
    outers, determination_1, separation_1 = outer_angles(table, p, free_rows)
    conditioning_1, determination_1, separation_1 = accuracy(base_conditioning(table), determination_1, separation_1, DOUBLE)
    for i in range(n):
        outer = one_of_two(outers, load(sign_rows, i))
        v = outer_vector(table, p, outer)
        inners, determination_2, separation_2 = inner_angles(table, family, p, v, free_rows)
        conditioning_2, determination_2, separation_2 = accuracy(conditioning_1, determination_2, separation_2, DOUBLE)
        determination_2, separation_2 = minimum(determination_1, determination_2), minimum(separation_1, separation_2)
        q_outer = full_circle_angle(outer[0], outer[1])
        for j in range(n):
            inner = one_of_two(inners, load(sign_rows, n + j))
            other, size = other_angle(table, family, p, v, inner, free_rows)
            q_inner, q_other = full_circle_angle(inner[0], inner[1]), full_circle_angle(other[0], other[1])
            first, second, third, angles = outer, other, inner, (q_outer, q_other, q_inner)
            if family in (INTERSECTING_12, PARALLEL_12):
                first, second, third, angles = other, inner, outer, (q_other, q_inner, q_outer)
            residual_square, row = position_square(table, p, first, second, third), (i * n + j) * n
            whole, determination = (
                wrist_matrix(table, first, second, third, last),
                minimum(determination_2, compared_determination(conditioning_2, size)),
            )
            conditioning = next_conditioning(conditioning_2, size)
            wrist(table, whole, angles, row, branches, Accuracy(residual_square, conditioning, determination, separation_2))


@kernel
def wrist(table, whole, angles, row, branches, known):
    """Step 3: write n branches from this row on.

    whole: W. angles: q_1, q_2 and q_3. known: ``branch_records.Accuracy``.
    """
    (sign_rows, n, free_rows, q_rows, known_rows), (residual_square, conditioning, determination, separation) = branches, known
    h4, h5, h6, axis = tabled(table, AXES + 3), tabled(table, AXES + 4), tabled(table, AXES + 5), column(whole, 2)
    bends, free = (table[BENDS, 0], table[BENDS, 1]), table[BENDS, FREE_WRIST]
    fifths, determination_5, separation_5 = angles_to_direction(h4, h6, h5, axis, bends, free_angle(free_rows, 4))
    _, determination_5, separation_5 = accuracy(conditioning, determination_5, separation_5, DOUBLE)
    nearest = separation if free != 0.0 else worse_separation(separation, separation_5)
    for k in range(n):
        fifth = one_of_two(fifths, load(sign_rows, 2 * n + k))
        r = fifth_turn(table, fifth)
        bent = column(r, 2)
        fourth, determination_4 = angle_onto_in_frame(bent, axis, free_angle(free_rows, 3))
        x = transposed_times(r, rotate_back_in_frame(fourth, column(whole, 0)))  # R_6 n_6
        sixth, _ = unit_angle(x[1], x[0], free_angle(free_rows, 5))
        store_angle(table, q_rows, row + k, 0, angles[0])
        store_angle(table, q_rows, row + k, 1, angles[1])
        store_angle(table, q_rows, row + k, 2, angles[2])
        store_angle(table, q_rows, row + k, 3, full_circle_angle(fourth[0], fourth[1]))
        store_angle(table, q_rows, row + k, 4, full_circle_angle(fifth[0], fifth[1]))
        store_angle(table, q_rows, row + k, 5, full_circle_angle(sixth[0], sixth[1]))
        e, f = minus(rotate_in_frame(fourth, bent), axis), minus(x, (sixth[1], sixth[0], 0.0))
        least = minimum(
            determination, maximum(minimum(compared_determination(conditioning, determination_4), determination_5), free)
        )
        store_properties(known_rows, row + k, residual_square + dot(e, e) + dot(f, f), least, nearest)


@kernel
def wrist_matrix(table, first, second, third, last):
    """W, from the columns of R F_6."""
    x = rotate_by_arm(table, first, second, third, tabled(table, NORMALS + OF_4))
    z = rotate_by_arm(table, first, second, third, tabled(table, AXES + 3))
    return by_columns((x, cross(z, x), z), last[0], last[1], last[2])


@kernel
def rotate_by_arm(table, first, second, third, v):
    """R_1 R_2 R_3 v."""
    v = turn(tabled(table, AXES + 1), second, turn(tabled(table, AXES + 2), third, v))
    return turn(tabled(table, AXES), first, v)


@kernel
def position_square(table, p, first, second, third):
    """|R_1' p - P_1 - R_2 (P_2 + R_3 P_3)|^2."""
    bent = plus(tabled(table, POINTS + 2), turn(tabled(table, AXES + 2), third, tabled(table, POINTS + 3)))
    e = minus(turn_back(tabled(table, AXES), first, p), tabled(table, POINTS + 1))
    e = minus(e, turn(tabled(table, AXES + 1), second, bent))
    return dot(e, e)


@kernel
def outer_angles(table, p, free_rows):
    """Step 1: both solutions of q_1 or q_3, their determination, and the distance of the roots."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    family = int(table[FORM, FAMILY])
    if family == PARALLEL_23:  # h_2 . R_1' p does not depend on q_2 and q_3
        return angles_to_plane(h2, p, reversed_vector(h1), dot(h2, plus(p1, plus(p2, p3))), free_angle(free_rows, 0))
    if family == INTERSECTING_12:  # P_1 = 0: |p| = |P_2 + R_3 P_3|
        return angles_to_sphere(reversed_vector(p3), p2, h3, dot(p, p), free_angle(free_rows, 2))
    if family == PARALLEL_12:  # h_1 . p does not depend on q_1 and q_2
        return angles_to_plane(h1, p3, h3, dot(h1, minus(minus(p, p1), p2)), free_angle(free_rows, 2))
    return angles_to_sphere(p, p1, reversed_vector(h1), dot(p3, p3), free_angle(free_rows, 0))  # P_2 = 0: |R_1' p - P_1| = |P_3|


@kernel
def outer_vector(table, p, outer):
    """R_1' p - P_1, or P_2 + R_3 P_3."""
    family = int(table[FORM, FAMILY])
    if family in (INTERSECTING_12, PARALLEL_12):
        return plus(tabled(table, POINTS + 2), turn(tabled(table, AXES + 2), outer, tabled(table, POINTS + 3)))
    return minus(turn_back(tabled(table, AXES), outer, p), tabled(table, POINTS + 1))


@kernel
def inner_angles(table, family, p, v, free_rows):
    """Step 2: both solutions of q_3, or of q_2 if q_3 is the outer angle; determination; distance of the roots."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    if family == PARALLEL_23:  # |v| = |P_2 + R_3 P_3|
        return angles_to_sphere(reversed_vector(p3), p2, h3, dot(v, v), free_angle(free_rows, 2))
    if family == INTERSECTING_12:  # h_1 . p = h_1 . R_2 v
        return angles_to_plane(h1, v, h2, dot(h1, p), free_angle(free_rows, 1))
    if family == PARALLEL_12:  # |p| = |P_1 + R_2 v|
        return angles_to_sphere(reversed_vector(v), p1, h2, dot(p, p), free_angle(free_rows, 1))
    return angles_to_plane(h2, p3, h3, dot(h2, v), free_angle(free_rows, 2))  # h_2 . v = h_2 . R_3 P_3


@kernel
def other_angle(table, family, p, v, inner, free_rows):
    """Step 2: q_2, or q_1 if q_3 is the outer angle; and its determination."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    if family == INTERSECTING_12:
        return angle_onto(turn(h2, inner, v), p, h1, free_angle(free_rows, 0))
    if family == PARALLEL_12:
        return angle_onto(plus(p1, turn(h2, inner, v)), p, h1, free_angle(free_rows, 0))
    if family == PARALLEL_23:
        return angle_onto(plus(p2, turn(h3, inner, p3)), v, h2, free_angle(free_rows, 1))
    return angle_onto(turn(h3, inner, p3), v, h2, free_angle(free_rows, 1))
