"""Solves two links about parallel axes 2 and 3 in the axes' frame; with a spherical wrist, the whole arm.

R_i is the rotation about axis i, and P_i the vector from axis i to axis i + 1 (``ik.closed_form.closed_form``). p is the vector
from axis 1 to the wrist's center, or to axis 6 if there is no wrist.

F is the frame of axis 2 (``closed_form_rows``). In ``v = F' R_1' p - F' P_1`` the component along the axis is known. ``two`` is
P_2 and ``three`` is P_3 in this frame: v = R_2 (two + R_3 three).

``parallel_wrist`` solves arms with a spherical wrist, such as most industrial arms. The module ``spherical_wrist`` describes its
steps and names their sources.
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
from ulna.kernels.chain.closed_form_layout import AXES, NORMALS, OF_2, OF_4, POINTS
from ulna.kernels.chain.closed_form_rows import (
    by_columns,
    end_frame,
    free_angle,
    in_frame,
    rotate_in_frame,
    store_angle,
    store_properties,
    tabled,
)
from ulna.kernels.chain.spherical_wrist import outer_angles, wrist
from ulna.kernels.chain.subproblems import angle_onto_in_frame, angles_to_sphere_in_frame, one_of_two, turn, wrapped
from ulna.kernels.spatial.elementary import full_circle_angle, minimum
from ulna.kernels.spatial.vectors import dot, minus, plus


@kernel
def outer_links(table, first, p, last):
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
    """|v| = |two + R_3 three|: both angles q_3, in the form of ``angles_to_plane``."""
    return angles_to_sphere_in_frame((-three[0], -three[1]), two, v[0] * v[0] + v[1] * v[1], free)


@kernel
def shoulder_angle(two, three, third, v, free):
    """v = R_2 (two + R_3 three): q_2, its determination, and the squared length of the error."""
    moved = rotate_in_frame(third, three)
    bent = two[0] + moved[0], two[1] + moved[1], 0.0
    second, determination = angle_onto_in_frame(bent, v, free)
    reached = rotate_in_frame(second, bent)
    x, y = reached[0] - v[0], reached[1] - v[1]
    return second, determination, x * x + y * y


@kernel
def four_angles(first, fifth, sixth, bend):
    """q_1, q_5, q_6 and ``bend`` as angles."""
    q_first, q_fifth = full_circle_angle(first[0], first[1]), full_circle_angle(fifth[0], fifth[1])
    return q_first, q_fifth, full_circle_angle(sixth[0], sixth[1]), full_circle_angle(bend[0], bend[1])


@kernel
def links(table, both, v, angles, row, branches, known):
    """Write n branches from this row on; angles: q_1, q_5, q_6 and q_2 + q_3 + q_4.

    both: two and three. v: Without the part behind joint 4. known: ``branch_records.Accuracy``.
    """
    (two, three), (residual_square, conditioning, determination, separation) = both, known
    sign_rows, n, free_rows, q_rows, known_rows = branches
    thirds, determination_3, separation_3 = elbow_angles(two, three, v, free_angle(free_rows, 2))
    conditioning_3, determination_3, separation_3 = accuracy(conditioning, determination_3, separation_3, DOUBLE)
    least, nearest = minimum(determination, determination_3), worse_separation(separation, separation_3)
    for k in range(n):
        third = one_of_two(thirds, load(sign_rows, 2 * n + k))
        second, determination_2, off = shoulder_angle(two, three, third, v, free_angle(free_rows, 1))
        q_second, q_third = full_circle_angle(second[0], second[1]), full_circle_angle(third[0], third[1])
        store_angle(table, q_rows, row + k, 0, angles[0])
        store_angle(table, q_rows, row + k, 1, q_second)
        store_angle(table, q_rows, row + k, 2, q_third)
        store_angle(table, q_rows, row + k, 3, wrapped(angles[3] - q_second - q_third))
        store_angle(table, q_rows, row + k, 4, angles[1])
        store_angle(table, q_rows, row + k, 5, angles[2])
        store_properties(
            known_rows,
            row + k,
            residual_square + off,
            minimum(least, compared_determination(conditioning_3, determination_2)),
            nearest,
        )


@kernel
def parallel_wrist(table, motion, p, branches):
    """Write all branches; the arguments are those of ``spherical_wrist``."""
    sign_rows, n, free_rows = branches.sign_rows, branches.n, branches.free_rows
    last, (two, three), onward = end_frame(table, motion), two_links(table), to_wrist(table)
    behind = dot(tabled(table, AXES + 1), plus(tabled(table, POINTS + 2), tabled(table, POINTS + 3)))
    firsts, determination_1, separation_1 = outer_angles(table, p, free_rows)
    conditioning_1, determination_1, separation_1 = accuracy(base_conditioning(table), determination_1, separation_1, DOUBLE)
    for i in range(n):
        first = one_of_two(firsts, load(sign_rows, i))
        v, turned_to = outer_links(table, first, p, last)
        off = v[2] - behind
        thirds, determination_3, separation_3 = elbow_angles(two, three, v, free_angle(free_rows, 2))
        conditioning_3, determination_3, separation_3 = accuracy(conditioning_1, determination_3, separation_3, DOUBLE)
        determination_3, separation_3 = minimum(determination_1, determination_3), minimum(separation_1, separation_3)
        q_first = full_circle_angle(first[0], first[1])
        for j in range(n):
            third = one_of_two(thirds, load(sign_rows, n + j))
            second, determination_2, residual_square = shoulder_angle(two, three, third, v, free_angle(free_rows, 1))
            angles = q_first, full_circle_angle(second[0], second[1]), full_circle_angle(third[0], third[1])
            both = second[0] * third[1] + second[1] * third[0], second[1] * third[1] - second[0] * third[0]
            whole = in_wrist(onward, both, turned_to)
            conditioning, determination = (
                next_conditioning(conditioning_3, determination_2),
                minimum(determination_3, compared_determination(conditioning_3, determination_2)),
            )
            row, residual_square = (i * n + j) * n, residual_square + off * off
            wrist(table, whole, angles, row, branches, Accuracy(residual_square, conditioning, determination, separation_3))


@kernel
def to_wrist(table):
    """F_4' F_2: three columns."""
    x, y = tabled(table, NORMALS + OF_2), tabled(table, NORMALS + OF_2 + 1)
    return in_frame(table, OF_4, 3, x), in_frame(table, OF_4, 3, y), in_frame(table, OF_4, 3, tabled(table, AXES + 1))


@kernel
def in_wrist(columns, angle, r):
    """F_4' F_2 times a matrix r of the frame of axis 2, rotated back about the axis: three rows."""
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
