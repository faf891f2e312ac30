"""Solves six revolute joints with axes 2, 3 and 4 parallel, and axes 5 and 6 intersecting.

Universal Robots' arms are of this kind.

``bend`` is the sum of the angles of axes 2, 3 and 4: R_2 R_3 R_4 = rot(h_2, bend).

1. h_2 . R_1' p = h_2 . (P_1 + P_2 + P_3 + P_4) gives q_1, with two solutions: everything behind axis 2 moves in planes.
2. h_2 . R_1' R h_6 = h_2 . R_5 h_6 gives q_5, with two solutions; R_6' R_5' h_2 = R' R_1 h_2 gives q_6, and the whole rotation
   ``bend``.
3. If sin q_5 = 0, axes 2 to 4 and 6 are parallel, and only ``bend`` and q_6 together are determined. Then q_6 takes the value
   that the caller gives for an undetermined angle (``free_rows``). With this value the two links may not reach. In this case
   ``bend`` is the nearest value for which they are just stretched or folded, and q_6 follows from it.
4. R_1' p - P_1 - rot(h_2, bend) P_4 = R_2 (P_2 + R_3 P_3): its length gives q_3, with two solutions, and its direction q_2.

All steps but the first are in the frames F_2 and F_6 of axes 2 and 6 (``closed_form_rows``, ``parallel_links``). W = F_2' R_1' R
F_6 is a matrix, for each q_1.

Source: Elias and Wen, IK-Geo (2022), section 5; Ostermeier, Kuelz and Althoff, EAIK (2024).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, sqrt
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, base_conditioning, compared_determination, next_conditioning
from ulna.kernels.chain.branch_records import Accuracy
from ulna.kernels.chain.closed_form_layout import AXES, BENDS, OF_2, POINTS
from ulna.kernels.chain.closed_form_rows import (
    column,
    end_frame,
    fifth_row,
    fifth_turn,
    free_angle,
    in_frame,
    rotate_back_in_frame,
    rotate_in_frame,
    tabled,
)
from ulna.kernels.chain.parallel_links import four_angles, links, outer_links, two_links
from ulna.kernels.chain.subproblems import (
    angle_onto_in_frame,
    angles_to_direction,
    angles_to_plane,
    angles_to_sphere_in_frame,
    chosen_angle,
    one_of_two,
    reversed_vector,
    subtracted,
    unit_angle,
)
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import dot, minus, plus, times, transposed_times

SINGULAR = 1e-40  # of the fourth power of sin q_5, after ``compared_determination``


@kernel
def three_parallel(table, motion, p, branches):
    """Write all branches.

    motion: G of ``closed_form``. p: The vector from the point on axis 1 to the point on axis 6.
    """
    sign_rows, n, free_rows = branches.sign_rows, branches.n, branches.free_rows
    h1, h2, h5, h6 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 4), tabled(table, AXES + 5)
    p1, p2, p3, p4 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3), tabled(table, POINTS + 4)
    behind = dot(h2, plus(plus(p2, p3), p4))
    firsts, determination_1, separation_1 = angles_to_plane(
        h2, p, reversed_vector(h1), dot(h2, p1) + behind, free_angle(free_rows, 0)
    )
    conditioning_1, determination_1, separation_1 = accuracy(base_conditioning(table), determination_1, separation_1, DOUBLE)
    last, both, four = end_frame(table, motion), two_links(table), in_frame(table, OF_2, 1, p4)
    bends = table[BENDS, 0], table[BENDS, 1]
    for i in range(n):
        first = one_of_two(firsts, load(sign_rows, i))
        v, whole = outer_links(table, first, p, last)
        off = v[2] - behind
        fifths, determination_5, separation_5 = angles_to_direction(h2, h6, h5, column(whole, 2), bends, free_angle(free_rows, 4))
        conditioning_5, determination_5, separation_5 = accuracy(conditioning_1, determination_5, separation_5, DOUBLE)
        if bends[0] + bends[1] == 0.0:  # the discriminant of q_5 keeps all digits (``angles_to_direction``)
            conditioning_5 = conditioning_1
        determination_5, separation_5 = minimum(determination_1, determination_5), minimum(separation_1, separation_5)
        for j in range(n):
            fifth = one_of_two(fifths, load(sign_rows, n + j))
            bend, sixth, residual_square, determination, conditioning = hand(
                table, whole, v, four, fifth, (conditioning_5, SINGULAR), free_rows
            )
            angles = four_angles(first, fifth, sixth, bend)
            rest, row = minus(v, rotate_in_frame(bend, four)), (i * n + j) * n
            known = Accuracy(residual_square + off * off, conditioning, minimum(determination_5, determination), separation_5)
            links(table, both, rest, angles, row, branches, known)


@kernel
def hand(table, whole, v, reach, fifth, limits, free_rows):
    """Steps 2 and 3 for an angle q_5: ``bend`` and q_6; squared rotation error; determination; and ``conditioning`` after them.

    whole: W. v and reach: R_1' p - P_1 and P_4 (or P_4 + R_5 P_5) in the frame of axis 2. limits: ``conditioning`` of q_5, and
    the value of ``determination`` below which the hand is singular.
    """
    conditioning_5, singular = limits
    across, along = fifth_row(table, 0, fifth), fifth_row(table, 2, fifth)  # R_5' n_2 and R_5' h_2, in the frame of axis 6
    sixth, determination = angle_onto_in_frame(whole[2], along, free_angle(free_rows, 5))
    t = times(whole, rotate_back_in_frame(sixth, across))
    bend, _ = unit_angle(t[1], t[0], (0.0, 1.0))
    conditioning, determination = (
        next_conditioning(conditioning_5, determination),
        compared_determination(conditioning_5, determination),
    )
    ends = determination <= singular
    if any_lane(ends):
        bend, sixth = within_reach(table, whole, v, reach, (fifth, sixth, bend), ends)
        t = times(whole, rotate_back_in_frame(sixth, across))
    e, f = minus(t, (bend[1], bend[0], 0.0)), minus(rotate_back_in_frame(sixth, along), whole[2])
    return bend, sixth, dot(e, e) + dot(f, f), determination, conditioning


@kernel
def within_reach(table, whole, v, reach, angles, singular):
    """Step 3: ``bend`` and q_6 in singular lanes where the two links do not reach. angles: q_5, q_6 and ``bend``."""
    (two, three), (fifth, sixth, bend) = two_links(table), angles
    # |two + R_3 three|^2 is between middle - half and middle + half.
    square_2, square_3 = two[0] * two[0] + two[1] * two[1], three[0] * three[0] + three[1] * three[1]
    middle, half = square_2 + square_3, 2.0 * sqrt(square_2 * square_3)
    rest = minus(v, rotate_in_frame(bend, reach))
    square = rest[0] * rest[0] + rest[1] * rest[1]
    goal = minimum(maximum(square, middle - half), middle + half)
    both, _, _ = angles_to_sphere_in_frame(reach, v, goal, bend)
    one, other = one_of_two(both, 1.0), one_of_two(both, -1.0)
    nearer = chosen_angle(subtracted(one, bend)[1] >= subtracted(other, bend)[1], one, other)
    moved = singular & (abs(goal - square) > 0.0)
    bend = chosen_angle(moved, nearer, bend)
    x = transposed_times(fifth_turn(table, fifth), rotate_back_in_frame(bend, column(whole, 0)))
    last, _ = unit_angle(x[1], x[0], sixth)
    return bend, chosen_angle(moved, last, sixth)
