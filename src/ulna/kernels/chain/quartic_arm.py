"""Solves six revolute joints whose first equation is a quartic.

There are two families, in the notation of ``three_parallel`` and ``spherical_wrist``. Each has two equations that are linear in
the sines and cosines of q_1 and of one other angle: a pair of circles (``two_circles``). The rest is as in those modules.

1. Axes 2, 3 and 4 are parallel, and P_5 is the vector from axis 5 to axis 6. Everything behind axis 2 moves in planes normal to
   h_2, and rotates about h_2. The equations h_2 . R_1' p - h_2 . (P_1 + .. + P_4) = h_2 . R_5 P_5 and h_2 . R_1' R h_6 = h_2 .
   R_5 h_6 give q_1 and q_5.
2. A spherical wrist behind any three axes: R_2 (P_2 + R_3 P_3) = R_1' p - P_1. Its length and its component along h_2 do not
   depend on q_2. They give q_1 and q_3 (Pieper 1968; subproblem 5 of Elias and Wen, IK-Geo, 2022).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, sqrt, where
from ulna.kernels.chain.accuracy import DOUBLE_OF_QUARTIC, accuracy, base_conditioning, compared_determination, next_conditioning
from ulna.kernels.chain.branch_records import Accuracy
from ulna.kernels.chain.closed_form_layout import AXES, HARDLY_DETERMINED, OF_2, POINTS
from ulna.kernels.chain.closed_form_rows import end_frame, free_angle, in_frame, rotate_in_frame, tabled
from ulna.kernels.chain.parallel_links import four_angles, links, outer_links, two_links
from ulna.kernels.chain.spherical_wrist import position_square, wrist, wrist_matrix
from ulna.kernels.chain.subproblems import angle_onto, reversed_vector, turn, turn_back
from ulna.kernels.chain.three_parallel import hand
from ulna.kernels.chain.two_circles import angle_of_pair, other_of_pair, passing, pencil
from ulna.kernels.spatial.elementary import full_circle_angle, minimum
from ulna.kernels.spatial.vectors import cross, dot, minus, plus, rotate

_ROWS_OFF = 1e-12  # error of two rows: the axes of an exact form may miss by that
_ROUNDING = 1e-15  # of the squares of u and B
_COMPLEX, _IN_DOUBT = -1.0, -1e-40  # values of ``separation`` for a pair that is not real (``accuracy``)


@kernel
def parts(h, k, v):
    """h . rot(k, angle) v as a constant, and the factors of the cosine and of the sine."""
    still = dot(h, k) * dot(k, v)
    return still, dot(h, v) - still, dot(h, cross(k, v))


@kernel
def circles(first, second, left_1, left_2):
    """u, the columns of B, and |L^-1|^2, from two equations with the rows L.

    An equation is ``first + (a_1, a_2) . x_1 = left . y``.

    Parts are numbers or lanes.
    """
    det = left_1[1] * left_2[2] - left_1[2] * left_2[1]
    r = 1.0 / det
    i_11, i_12, i_21, i_22 = left_2[2] * r, -left_1[2] * r, -left_2[1] * r, left_1[1] * r
    b_1, b_2 = first[0] - left_1[0], second[0] - left_2[0]
    u = i_11 * b_1 + i_12 * b_2, i_21 * b_1 + i_22 * b_2
    column_1 = -(i_11 * first[1] + i_12 * second[1]), -(i_21 * first[1] + i_22 * second[1])
    column_2 = -(i_11 * first[2] + i_12 * second[2]), -(i_21 * first[2] + i_22 * second[2])
    return u, column_1, column_2, i_11 * i_11 + i_12 * i_12 + i_21 * i_21 + i_22 * i_22


@kernel
def square_of_size(u, v):
    """|u|^2 + |v|^2."""
    return u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1]


@kernel
def first_of_circles(conditioning, p, u, b_1, b_2, inverse):
    """``conditioning`` for y = u - B x, the pencil, and masks of its lines that surely miss the circle.

    The error of u and B is |L^-1| times that of the two rows. The error of y is up to |B| times that of x.
    """
    of_b = square_of_size(b_1, b_2)
    axes, form, lines, size = pencil(u, b_1, b_2)
    rows = _ROWS_OFF * (1.0 + dot(p, p)) * sqrt(inverse / conditioning)
    off = (rows + _ROUNDING * (1.0 + of_b + square_of_size(u, u))) / size
    return 0.1 * conditioning / (1.0 + of_b), (axes, form, lines, size), passing(form, lines, off)


@kernel
def one_of_pencil(conditioning, both, passing_lines, line, sign, free):
    """An angle of the first circle, ``conditioning`` after it, its determination, and the compared value of ``separation``."""
    axes, form, lines, size = both
    angle, determination, slope, is_root = angle_of_pair(axes, form, lines, size, line, sign, free)
    conditioning, determination, separation = accuracy(conditioning, determination, slope, DOUBLE_OF_QUARTIC)
    passes = ((line > 0.0) & passing_lines[0]) | ((line < 0.0) & passing_lines[1])
    return angle, conditioning, determination, where(is_root, separation, where(passes, _COMPLEX, _IN_DOUBT))


@kernel
def offset_hand(table, motion, p, branches):
    """Family 1: write all branches; the arguments are those of ``three_parallel``."""
    sign_rows, n, free_rows = branches.sign_rows, branches.n, branches.free_rows
    h1, h2, h5, h6 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 4), tabled(table, AXES + 5)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    p4, p5 = tabled(table, POINTS + 4), tabled(table, POINTS + 5)
    back, last, links_of_arm = reversed_vector(h1), end_frame(table, motion), two_links(table)
    behind = dot(h2, plus(plus(p2, p3), p4))
    ahead = parts(h2, back, p)
    ahead = ahead[0] - dot(h2, p1) - behind, ahead[1], ahead[2]
    u, b_1, b_2, inverse = circles(ahead, parts(h2, back, rotate(motion, h6)), parts(h2, h5, p5), parts(h2, h5, h6))
    conditioning_0, both, passing_lines = first_of_circles(base_conditioning(table), p, u, b_1, b_2, inverse)
    for i in range(n):
        for j in range(n):
            line, sign = load(sign_rows, i), load(sign_rows, n + j)
            first, conditioning_1, determination_1, separation = one_of_pencil(
                conditioning_0, both, passing_lines, line, sign, free_angle(free_rows, 0)
            )
            fifth = other_of_pair(u, b_1, b_2, first)
            v, whole = outer_links(table, first, p, last)
            reach = in_frame(table, OF_2, 1, plus(p4, turn(h5, fifth, p5)))
            # At a singular hand the quartic has a double root.
            bend, sixth, residual_square, determination, conditioning = hand(
                table, whole, v, reach, fifth, (conditioning_1, HARDLY_DETERMINED), free_rows
            )
            angles = four_angles(first, fifth, sixth, bend)
            rest, row = minus(v, rotate_in_frame(bend, reach)), (i * n + j) * n
            off = v[2] - reach[2] - dot(h2, plus(p2, p3))
            known = Accuracy(residual_square + off * off, conditioning, minimum(determination_1, determination), separation)
            links(table, links_of_arm, rest, angles, row, branches, known)


@kernel
def any_three_axes(table, motion, p, branches):
    """Family 2: write all branches; the arguments are those of ``spherical_wrist``."""
    sign_rows, n, free_rows = branches.sign_rows, branches.n, branches.free_rows
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    p1, p2, p3 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    back, last = reversed_vector(h1), end_frame(table, motion)
    length, ahead = parts(p1, back, p), parts(h2, back, p)
    half = 0.5 * (dot(p, p) + dot(p1, p1) - dot(p2, p2) - dot(p3, p3))
    length = half - length[0], -length[1], -length[2]
    ahead = ahead[0] - dot(h2, plus(p1, p2)), ahead[1], ahead[2]
    u, b_1, b_2, inverse = circles(length, ahead, parts(p2, h3, p3), parts(h2, h3, p3))
    conditioning_0, both, passing_lines = first_of_circles(base_conditioning(table), p, u, b_1, b_2, inverse)
    for i in range(n):
        for j in range(n):
            line, sign = load(sign_rows, i), load(sign_rows, n + j)
            first, conditioning_1, determination, separation = one_of_pencil(
                conditioning_0, both, passing_lines, line, sign, free_angle(free_rows, 0)
            )
            third = other_of_pair(u, b_1, b_2, first)
            v, bent = minus(turn_back(h1, first, p), p1), plus(p2, turn(h3, third, p3))
            second, determination_2 = angle_onto(bent, v, h2, free_angle(free_rows, 1))
            conditioning, determination_2 = (
                next_conditioning(conditioning_1, determination_2),
                compared_determination(conditioning_1, determination_2),
            )
            residual_square, determination = (
                position_square(table, p, first, second, third),
                minimum(determination, determination_2),
            )
            whole, row = wrist_matrix(table, first, second, third, last), (i * n + j) * n
            angles = (
                full_circle_angle(first[0], first[1]),
                full_circle_angle(second[0], second[1]),
                full_circle_angle(third[0], third[1]),
            )
            wrist(table, whole, angles, row, branches, Accuracy(residual_square, conditioning, determination, separation))
