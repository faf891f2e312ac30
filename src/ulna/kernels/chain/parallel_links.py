"""Solves two links about parallel axes 2 and 3, in the frame of these.

In the frame F of axis 2 (``frames``) v = F' R_1' p - F' P_1 is a plane vector, but for its part along the axis, which is known.
Two is P_2 and three is P_3 there: v = R_2 (two + R_3 three).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, sure_behind, worse
from ulna.kernels.chain.closed_form_layout import AXES, NORMALS, OF_2, OF_6, POINTS
from ulna.kernels.chain.closed_form_rows import free_angle, put, put_known, tabled
from ulna.kernels.chain.frames import by_columns, in_frame, turned
from ulna.kernels.chain.subproblems import angle_onto_in_frame, angles_to_sphere_in_frame, one_of_two, turn, wrapped
from ulna.kernels.spatial.arc_tangent import full_circle_angle
from ulna.kernels.spatial.elementary import minimum
from ulna.kernels.spatial.vectors import dot, minus, rotate


@kernel
def end_frame(table, motion):
    """R F_6: three columns."""
    x, y = rotate(motion, tabled(table, NORMALS + OF_6)), rotate(motion, tabled(table, NORMALS + OF_6 + 1))
    return x, y, rotate(motion, tabled(table, AXES + 5))


@kernel
def behind_first(table, first, p, last):
    """v, and the matrix F' R_1' R F_6 from the columns of R F_6."""
    h1, n2, w2 = tabled(table, AXES), tabled(table, NORMALS + OF_2), tabled(table, NORMALS + OF_2 + 1)
    r = turn(h1, first, n2), turn(h1, first, w2), turn(h1, first, tabled(table, AXES + 1))
    v = minus((dot(r[0], p), dot(r[1], p), dot(r[2], p)), in_frame(table, OF_2, 1, tabled(table, POINTS + 1)))
    return v, by_columns(r, last[0], last[1], last[2])


@kernel
def two_links(table):
    """P_2 and P_3 in the frame of axis 2."""
    return in_frame(table, OF_2, 1, tabled(table, POINTS + 2)), in_frame(table, OF_2, 1, tabled(table, POINTS + 3))


@kernel
def elbow_angles(two, three, v, free):
    """|v| = |two + R_3 three|: both angles q_3; returns as ``angles_to_plane``."""
    return angles_to_sphere_in_frame((-three[0], -three[1]), two, v[0] * v[0] + v[1] * v[1], free)


@kernel
def shoulder_angle(two, three, third, v, free):
    """v = R_2 (two + R_3 three): q_2; how well it is determined; and what is missed, the square of its length."""
    moved = turned(third, three)
    bent = two[0] + moved[0], two[1] + moved[1], 0.0
    second, sure = angle_onto_in_frame(bent, v, free)
    reached = turned(second, bent)
    x, y = reached[0] - v[0], reached[1] - v[1]
    return second, sure, x * x + y * y


@kernel
def four_angles(first, fifth, sixth, bend):
    """q_1, q_5, q_6 and ``bend`` as angles."""
    q_first, q_fifth = full_circle_angle(first[0], first[1]), full_circle_angle(fifth[0], fifth[1])
    return q_first, q_fifth, full_circle_angle(sixth[0], sixth[1]), full_circle_angle(bend[0], bend[1])


@kernel
def links(table, two, three, v, angles, row, sign_rows, n, free_rows, q_rows, known_rows, missed, near, sure, apart):
    """Write n branches from that row on: ``angles`` are q_1, q_5, q_6 and q_2 + q_3 + q_4; v without what is behind joint 4."""
    thirds, sure_3, apart_3 = elbow_angles(two, three, v, free_angle(free_rows, 2))
    near_3, sure_3, apart_3 = accuracy(near, sure_3, apart_3, DOUBLE)
    least, nearest = minimum(sure, sure_3), worse(apart, apart_3)
    for k in range(n):
        third = one_of_two(thirds, load(sign_rows, 2 * n + k))
        second, sure_2, off = shoulder_angle(two, three, third, v, free_angle(free_rows, 1))
        q_second, q_third = full_circle_angle(second[0], second[1]), full_circle_angle(third[0], third[1])
        put(table, q_rows, row + k, 0, angles[0])
        put(table, q_rows, row + k, 1, q_second)
        put(table, q_rows, row + k, 2, q_third)
        put(table, q_rows, row + k, 3, wrapped(angles[3] - q_second - q_third))
        put(table, q_rows, row + k, 4, angles[1])
        put(table, q_rows, row + k, 5, angles[2])
        put_known(known_rows, row + k, missed + off, minimum(least, sure_behind(near_3, sure_2)), nearest)
