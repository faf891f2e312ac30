"""Solves arms of six revolute joints whose axes 2, 3 and 4 are parallel and 5 and 6 intersect. Used by ``closed_form``.

So are Universal Robots' arms. The angle of axes 2, 3 and 4 together is that of R_2 R_3 R_4 = rot(h_2, bend).

Source: Elias and Wen, IK-Geo (2022), section 5; Ostermeier, Kuelz and Althoff, EAIK (2024).
1. h_2 . R_1' p = h_2 . (P_1 + P_2 + P_3 + P_4) gives q_1, two of them: what lies behind axis 2 moves in planes.
2. h_2 . R_1' R h_6 = h_2 . R_5 h_6 gives q_5, two of them; R_6' R_5' h_2 = R' R_1 h_2 gives q_6, and the whole rotation ``bend``.
3. Where sin q_5 = 0 the axes 2 to 4 and 6 are parallel, and only ``bend`` and q_6 together are determined: q_6 is the free one,
   unless the two links do not reach then; if so ``bend`` is the nearest for which they are just stretched or folded.
4. R_1' p - P_1 - rot(h_2, bend) P_4 = R_2 (P_2 + R_3 P_3): its length gives q_3, two of them, its direction q_2.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, sqrt
from ulna.kernels.chain.accuracy import DOUBLE, accuracy, near_behind, sure_behind
from ulna.kernels.chain.closed_form_layout import AXES, BENDS, NORMALS, POINTS
from ulna.kernels.chain.closed_form_rows import free_angle, put, put_known, tabled
from ulna.kernels.chain.subproblems import (
    angle_onto,
    angle_to_direction,
    angle_to_plane,
    angle_to_sphere,
    chosen_angle,
    reversed_vector,
    subtracted,
    turn,
    turn_back,
    wrapped,
)
from ulna.kernels.spatial.arc_tangent import full_circle_angle
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import dot, minus, plus, rotate, rotate_inverse

SINGULAR = 1e-40  # of the fourth power of sin q_5, by ``sure_behind``


@kernel
def three_parallel(table, motion, p, sign_rows, n, free_rows, q_rows, known_rows):
    """Write all branches; the arguments are those of ``closed_form``, and p from the point on axis 1 to that on axis 6."""
    h1, h2 = tabled(table, AXES), tabled(table, AXES + 1)
    p1, p2, p3, p4 = tabled(table, POINTS + 1), tabled(table, POINTS + 2), tabled(table, POINTS + 3), tabled(table, POINTS + 4)
    d = dot(h2, plus(plus(p1, p2), plus(p3, p4)))
    whole_axis = rotate(motion, tabled(table, AXES + 5))
    for i in range(n):
        first, sure_1, apart_1 = angle_to_plane(h2, p, reversed_vector(h1), d, load(sign_rows, i), free_angle(free_rows, 0))
        near_1, sure_1, apart_1 = accuracy(1.0, sure_1, apart_1, DOUBLE)
        q_first = full_circle_angle(first[0], first[1])
        v = minus(turn_back(h1, first, p), p1)
        axis = turn_back(h1, first, whole_axis)
        plane = rotate_inverse(motion, turn(h1, first, h2))
        for j in range(n):
            sign = load(sign_rows, n + j)
            bend, fifth, sixth, sure, apart, near = hand(table, motion, v, first, axis, plane, near_1, sign, free_rows)
            q_fifth, q_sixth = full_circle_angle(fifth[0], fifth[1]), full_circle_angle(sixth[0], sixth[1])
            q_bend = full_circle_angle(bend[0], bend[1])
            missed = rotation_square(table, motion, first, axis, bend, fifth, sixth)
            rest = minus(v, turn(h2, bend, p4))
            sure, apart = minimum(sure, sure_1), minimum(apart, apart_1)
            for k in range(n):
                branch = (i * n + j) * n + k
                put(table, q_rows, branch, 0, q_first)
                put(table, q_rows, branch, 4, q_fifth)
                put(table, q_rows, branch, 5, q_sixth)
                sign = load(sign_rows, 2 * n + k)
                links(table, rest, q_bend, sign, free_rows, q_rows, known_rows, branch, missed, near, sure, apart)


@kernel
def hand(table, motion, v, first, axis, plane, near, sign, free_rows):
    """Steps 2 and 3: ``bend``, q_5 and q_6; how well they are determined, how far apart the two are, and ``near`` behind them."""
    h2, h5, h6 = tabled(table, AXES + 1), tabled(table, AXES + 4), tabled(table, AXES + 5)
    bends = table[BENDS, 0], table[BENDS, 1]
    fifth, sure_5, apart = angle_to_direction(h2, h6, h5, axis, bends, sign, free_angle(free_rows, 4))
    sixth, sure_6 = angle_onto(plane, turn_back(h5, fifth, h2), h6, free_angle(free_rows, 5))
    bend = bend_of(table, motion, first, fifth, sixth)
    near_5, sure_5, apart = accuracy(near, sure_5, apart, DOUBLE)
    if bends[0] + bends[1] == 0.0:  # the discriminant of q_5 keeps all digits (``angle_to_direction``)
        near_5 = near
    near, sure_6 = near_behind(near_5, sure_6), sure_behind(near_5, sure_6)
    singular = sure_6 <= SINGULAR
    if any_lane(singular):
        bend, sixth = within_reach(table, motion, v, tabled(table, POINTS + 4), first, fifth, sixth, bend, singular)
    return bend, fifth, sixth, minimum(sure_5, sure_6), apart, near


@kernel
def bend_of(table, motion, first, fifth, sixth):
    """The angle of rot(h_2, bend) = R_1' R R_6' R_5'."""
    h1, h2, n2 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, NORMALS)
    h5, h6 = tabled(table, AXES + 4), tabled(table, AXES + 5)
    turned = turn_back(h1, first, rotate(motion, turn_back(h6, sixth, turn_back(h5, fifth, n2))))
    bend, _ = angle_onto(n2, turned, h2, (0.0, 1.0))
    return bend


@kernel
def within_reach(table, motion, v, hand, first, fifth, sixth, bend, singular):
    """Step 3: ``bend`` and q_6, where the mask is true and the two links do not reach; ``hand`` is P_4, or P_4 + R_5 P_5."""
    h1, h2, h3 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, AXES + 2)
    h5, h6, n6 = tabled(table, AXES + 4), tabled(table, AXES + 5), tabled(table, NORMALS + 1)
    p2, p3 = tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    # |P_2 + R_3 P_3|^2 is between middle - half and middle + half.
    middle = dot(p2, p2) + dot(p3, p3) + 2.0 * dot(h3, p2) * dot(h3, p3)
    half = 2.0 * sqrt(max((dot(p2, p2) - dot(h3, p2) ** 2) * (dot(p3, p3) - dot(h3, p3) ** 2), 0.0))
    rest = minus(v, turn(h2, bend, hand))
    square = dot(rest, rest)
    goal = minimum(maximum(square, middle - half), middle + half)
    one, _, _ = angle_to_sphere(hand, v, h2, goal, 1.0, bend)
    two, _, _ = angle_to_sphere(hand, v, h2, goal, -1.0, bend)
    nearer = chosen_angle(subtracted(one, bend)[1] >= subtracted(two, bend)[1], one, two)
    moved = singular & (abs(goal - square) > 0.0)
    bend = chosen_angle(moved, nearer, bend)
    turned = turn_back(h5, fifth, turn_back(h2, bend, turn_back(h1, first, rotate(motion, n6))))
    last, _ = angle_onto(n6, turned, h6, sixth)
    return bend, chosen_angle(moved, last, sixth)


@kernel
def rotation_square(table, motion, first, axis, bend, fifth, sixth):
    """What rot(h_2, bend) R_5 R_6 misses of R_1' R, by h_6 and a normal to it: the sum of squares."""
    h1, h2, n6 = tabled(table, AXES), tabled(table, AXES + 1), tabled(table, NORMALS + 1)
    h5, h6 = tabled(table, AXES + 4), tabled(table, AXES + 5)
    e = minus(turn(h2, bend, turn(h5, fifth, h6)), axis)
    f = minus(turn(h2, bend, turn(h5, fifth, turn(h6, sixth, n6))), turn_back(h1, first, rotate(motion, n6)))
    return dot(e, e) + dot(f, f)


@kernel
def links(table, rest, q_bend, sign, free_rows, q_rows, known_rows, branch, missed, near, sure, apart):
    """Step 4: write q_2, q_3, q_4 and what is known of the branch; ``rest`` is R_2 (P_2 + R_3 P_3)."""
    h2, h3, p2, p3 = tabled(table, AXES + 1), tabled(table, AXES + 2), tabled(table, POINTS + 2), tabled(table, POINTS + 3)
    square = dot(rest, rest)
    third, sure_3, apart_3 = angle_to_sphere(reversed_vector(p3), p2, h3, square, sign, free_angle(free_rows, 2))
    bent = plus(p2, turn(h3, third, p3))
    second, sure_2 = angle_onto(bent, rest, h2, free_angle(free_rows, 1))
    q_second, q_third = full_circle_angle(second[0], second[1]), full_circle_angle(third[0], third[1])
    put(table, q_rows, branch, 1, q_second)
    put(table, q_rows, branch, 2, q_third)
    put(table, q_rows, branch, 3, wrapped(q_bend - q_second - q_third))
    e = minus(rest, turn(h2, second, bent))
    near, sure_3, apart_3 = accuracy(near, sure_3, apart_3, DOUBLE)
    sure = minimum(sure, minimum(sure_behind(near, sure_2), sure_3))
    put_known(known_rows, branch, missed + dot(e, e), sure, minimum(apart, apart_3))
