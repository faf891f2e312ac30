"""Solves six revolute joints: a spherical wrist, axes 2 and 3 parallel, as industrial arms have.

It is the first family of ``spherical_wrist``, with its steps and sources, in the frame of axis 2 (``parallel_links``).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, near_base, near_behind, sure_behind
from ulna.kernels.chain.closed_form_layout import AXES, NORMALS, OF_2, OF_4, POINTS
from ulna.kernels.chain.closed_form_rows import free_angle, tabled
from ulna.kernels.chain.frames import in_frame
from ulna.kernels.chain.parallel_links import behind_first, elbow_angles, end_frame, shoulder_angle, two_links
from ulna.kernels.chain.spherical_wrist import outer_angles, wrist
from ulna.kernels.chain.subproblems import one_of_two
from ulna.kernels.spatial.arc_tangent import full_circle_angle
from ulna.kernels.spatial.elementary import minimum
from ulna.kernels.spatial.vectors import dot, plus


@kernel
def parallel_wrist(table, motion, p, sign_rows, n, free_rows, q_rows, known_rows):
    """Write all branches; the arguments are those of ``spherical_wrist``."""
    last, (two, three), onward = end_frame(table, motion), two_links(table), to_wrist(table)
    behind = dot(tabled(table, AXES + 1), plus(tabled(table, POINTS + 2), tabled(table, POINTS + 3)))
    firsts, sure_1, apart_1 = outer_angles(table, p, free_rows)
    near_1, sure_1, apart_1 = accuracy(near_base(table), sure_1, apart_1, DOUBLE)
    for i in range(n):
        first = one_of_two(firsts, load(sign_rows, i))
        v, turned_to = behind_first(table, first, p, last)
        off = v[2] - behind
        thirds, sure_3, apart_3 = elbow_angles(two, three, v, free_angle(free_rows, 2))
        near_3, sure_3, apart_3 = accuracy(near_1, sure_3, apart_3, DOUBLE)
        sure_3, apart_3 = minimum(sure_1, sure_3), minimum(apart_1, apart_3)
        q_first = full_circle_angle(first[0], first[1])
        for j in range(n):
            third = one_of_two(thirds, load(sign_rows, n + j))
            second, sure_2, missed = shoulder_angle(two, three, third, v, free_angle(free_rows, 1))
            angles = q_first, full_circle_angle(second[0], second[1]), full_circle_angle(third[0], third[1])
            both = second[0] * third[1] + second[1] * third[0], second[1] * third[1] - second[0] * third[0]
            whole = in_wrist(onward, both, turned_to)
            near, sure = near_behind(near_3, sure_2), minimum(sure_3, sure_behind(near_3, sure_2))
            row, missed = (i * n + j) * n, missed + off * off
            wrist(table, whole, angles, row, sign_rows, n, free_rows, q_rows, known_rows, missed, near, sure, apart_3)


@kernel
def to_wrist(table):
    """F_4' F_2: three columns."""
    x, y = tabled(table, NORMALS + OF_2), tabled(table, NORMALS + OF_2 + 1)
    return in_frame(table, OF_4, 3, x), in_frame(table, OF_4, 3, y), in_frame(table, OF_4, 3, tabled(table, AXES + 1))


@kernel
def in_wrist(columns, angle, r):
    """F_4' F_2 times a matrix r of the frame of axis 2, turned back about that: three rows."""
    s, c = angle
    x, y, z = r
    x, y = (
        (c * x[0] + s * y[0], c * x[1] + s * y[1], c * x[2] + s * y[2]),
        (c * y[0] - s * x[0], c * y[1] - s * x[1], c * y[2] - s * x[2]),
    )
    return row_of(columns, 0, x, y, z), row_of(columns, 1, x, y, z), row_of(columns, 2, x, y, z)


@kernel
def row_of(columns, i, x, y, z):
    """Row i of a matrix given by its columns times one given by its rows."""
    a, b, c = columns[0][i], columns[1][i], columns[2][i]
    return a * x[0] + b * y[0] + c * z[0], a * x[1] + b * y[1] + c * z[1], a * x[2] + b * y[2] + c * z[2]
