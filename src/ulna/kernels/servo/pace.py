"""Computes which share of its twist is asked of a hand, so that the arm may brake before it is stretched, and rests there.

Let X be the joint velocities that follow the twists w in full, however fast: the solution of the quadratic program without limits
of velocity and acceleration, but with ends of joints and near pairs (the steady motion). So H X = J^T M w, with H = J^T M J and
the damping, M the weights of what is along and beside a twist. The arm is to move with s X, s being the pace. Along X its
Jacobian changes by J', by a difference of J here and a little ahead, and X by z - y (on the active rows):

    H y = J^T M (J' X),    H z = J'^T M (w - J X)

Where a near pair is active, the change g' of its gradient g times its multiplier is added to the right side of z, and y has
g^T y = g'^T X. y is what keeps the hand's velocity while J changes, and z what the damping takes of it. Where the hand comes to
the end of its reach, at a distance d of the joints, both lead there: of one joint, whose column is k d, |X|^2 / (|y| + |z|) = d,
however near that is. So with B = |y| + |z|

    s^2 B / a + s lag B / |X| <= 1 - rest / d,    d = |X|^2 / B

the speed |s X| is at most sqrt(a d), which a deceleration of a / 2 brings down to zero in d, and near the end at most d / lag. So
the arm comes to rest at a distance ``rest`` from there. On the way back, where J' X is along w, ``rest`` is 0, and so it is for
a pose, to which other joints may still come nearer. Elsewhere the pace is 1, unless the twist asks for a greater acceleration
than there is.

Source: the acceleration along a path is that of Bobrow, Dubowsky and Gibson (1985); slowing by the singular values is that of
Nakamura and Hanafusa (1986).
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.ik.damped_system import add_column, column_dot, load_six
from ulna.kernels.servo.desired_motion import SMALL, dot_six, scaled_six, size_of, weigh_jacobians, weighted, write_jacobians
from ulna.kernels.servo.quadratic_program import minimise, solve_on_rows
from ulna.kernels.servo.servo_layout import ACCELERATION, GIVEN, HAND_WIDTH, LAG, LOWER, POSE, UPPER, WEIGHT

_AHEAD = 1e-4  # [rad or m]: how far the joint that moves farthest is ahead where the difference is taken
_SHARE = 0.7  # of the acceleration
_LAG, _LAG_TICKS = 0.05, 8.0  # [s], ticks: the time constant near the end of the reach, the longer of both
_REST = 1e-3  # [rad or m]: from the end of the reach
_BESIDE = 0.01, 0.02  # of what is along a twist: with less beside it a hand follows, and with more it rests
_RATE = 1e3  # [1/s], at which a joint may come to its end, or a pair nearer
_STILL = 1e-9  # [rad/s or m/s]
_SINGULAR = 0.1  # [m/rad, or rad/rad]: near a singularity a unit of the joints moves the hand by less along its twist
BLURRED = 4e-3  # [rad or m]: what is near where pairs are active is reckoned with down to this distance
NOT_SLOWED, SINGULAR = -2, -1
_ZERO = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def write_steady_bounds(limits, q_rows, excess, reserve, bound_rows):
    """Write the bounds of the steady motion, the ends of the joints first and then the near pairs.

    excess: how much farther each pair is apart than it has to be [m], less a reserve. A bound counts only very near an end: it is
    no limit of velocity, which would hide how X grows.
    """
    n = q_rows.shape[0]
    for j in range(n):
        bound_rows[j] = -_RATE * max(q_rows[j] - limits[LOWER, j], 0.0)
        bound_rows[n + j] = -_RATE * max(limits[UPPER, j] - q_rows[j], 0.0)
    for r in range(2 * n, bound_rows.shape[0]):
        bound_rows[r] = -_RATE * max(excess[r - 2 * n] - reserve, 0.0)


@routine
def write_steady(objective, normal_rows, m, work_rows, steady):
    """Write the steady motion; how many rows are active."""
    for i in range(objective.h_rows.shape[0]):
        steady.h_rows[i] = objective.h_rows[i]
    for j in range(objective.f_rows.shape[0]):
        steady.f_rows[j], steady.x_rows[j] = objective.f_rows[j], 0.0
    return minimise(
        steady.h_rows,
        steady.f_rows,
        normal_rows,
        steady.bound_rows,
        m,
        steady.x_rows,
        steady.active_rows,
        steady.multiplier_rows,
        work_rows,
    )


@routine
def write_changes(chains, goal_rows, limits, q_rows, objective, steady):
    """Write how J of each hand changes along the steady motion; return the time [s] to where the difference is taken."""
    fastest = _STILL
    for j in range(q_rows.shape[0]):
        fastest = max(fastest, abs(steady.x_rows[j]))
    time = _AHEAD / fastest
    for j in range(q_rows.shape[0]):
        steady.ahead_rows[j] = q_rows[j] + time * steady.x_rows[j]
    write_jacobians(chains, goal_rows, limits, steady.ahead_rows, steady.jacobian_rows)
    weigh_jacobians(goal_rows, steady.jacobian_rows)
    for i in range(steady.jacobian_rows.shape[0]):
        steady.jacobian_rows[i] = (steady.jacobian_rows[i] - objective.jacobian_rows[i]) / time
    return time


@routine
def write_growth(goal_rows, objective, steady, normal_rows, work_rows, k, across):
    """Write y and z, with so many active rows."""
    n = steady.x_rows.shape[0]
    for j in range(n):
        steady.kept_rows[j], steady.lost_rows[j] = 0.0, 0.0
    for i in range(goal_rows.shape[0] // HAND_WIDTH):
        columns, changes = objective.jacobian_rows[6 * n * i : 6 * n * (i + 1)], steady.jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        w, beside = load_six(objective.desired_rows, 6 * i), 1.0 if goal_rows[HAND_WIDTH * i + GIVEN] == POSE else across
        change, left = _ZERO, w
        for j in range(n):
            change, left = add_column(change, changes, j, steady.x_rows[j]), add_column(left, columns, j, -steady.x_rows[j])
        change, left = weighted(change, w, beside), weighted(left, w, beside)
        for j in range(n):
            steady.kept_rows[j] += column_dot(columns, j, change)
            steady.lost_rows[j] += column_dot(changes, j, left)
    for a in range(k):
        steady.value_rows[a] = 0.0
        for j in range(n):
            steady.lost_rows[j] += steady.multiplier_rows[a] * steady.turn_rows[n * a + j]
    solve_on_rows(steady.h_rows, normal_rows, steady.active_rows, steady.value_rows, k, steady.lost_rows, work_rows)
    for a in range(k):
        steady.value_rows[a] = 0.0
        for j in range(n):
            steady.value_rows[a] += steady.turn_rows[n * a + j] * steady.x_rows[j]
    solve_on_rows(steady.h_rows, normal_rows, steady.active_rows, steady.value_rows, k, steady.kept_rows, work_rows)


@routine
def write_paces(goal_rows, limits, settings, objective, steady, across, least):
    """Write the pace of each hand; return the joint of the slowest whose acceleration slows it, SINGULAR or NOT_SLOWED.

    least: the distance to the end of the reach that is reckoned with at least [rad or m]: gradients of pairs may jump.
    """
    n, slowest, found = steady.x_rows.shape[0], 1.0, NOT_SLOWED
    for i in range(goal_rows.shape[0] // HAND_WIDTH):
        columns, w = objective.jacobian_rows[6 * n * i : 6 * n * (i + 1)], load_six(objective.desired_rows, 6 * i)
        changes, change = steady.jacobian_rows[6 * n * i : 6 * n * (i + 1)], _ZERO
        v, size, rate, growth, joint = _ZERO, 0.0, 0.0, 0.0, NOT_SLOWED
        for j in range(n):
            v, change = add_column(v, columns, j, steady.x_rows[j]), add_column(change, changes, j, steady.x_rows[j])
            if is_moved_by(columns, j):
                a = limits[ACCELERATION, j]
                size, rate = max(size, abs(steady.x_rows[j])), max(rate, abs(steady.x_rows[j]) / a)
                grows = (abs(steady.kept_rows[j]) + abs(steady.lost_rows[j])) / a
                if grows > growth:
                    growth, joint = grows, j
        if size > _STILL:
            growth = min(growth, rate * size / max(least, 1e-300))
            is_to_rest = dot_six(change, w) < 0.0 and goal_rows[HAND_WIDTH * i + GIVEN] != POSE
            objective.pace_rows[i] = pace_of(size, rate, growth, _REST if is_to_rest else 0.0, settings)
        if objective.pace_rows[i] < slowest:
            is_singular = size_of(v) < _SINGULAR * size * sqrt(goal_rows[HAND_WIDTH * i + WEIGHT])
            slowest, found = objective.pace_rows[i], SINGULAR if is_singular else joint
        if across > 1.0 and goal_rows[HAND_WIDTH * i + GIVEN] != POSE and size_of(w) > SMALL:
            objective.pace_rows[i] *= share_along(columns, w, steady.x_rows)
    return found


@kernel
def is_moved_by(columns, j):
    """Whether entry j of q moves a hand."""
    moves = 0.0
    for k in range(6):
        moves = max(moves, abs(columns[6 * j + k]))
    return moves > 0.0


@kernel
def pace_of(size, rate, growth, rest, settings):
    """The pace: by the greatest |X|, the greatest |X| and B by the accelerations of the joints, and where the arm rests."""
    if growth <= _STILL * rate:
        return 1.0
    left = 1.0 - rest * growth / (rate * size)
    if left <= 0.0:
        return 0.0
    a, b = growth / _SHARE, max(_LAG, _LAG_TICKS * settings[LAG]) * growth / rate
    return min(1.0, 2.0 * left / (b + sqrt(b * b + 4.0 * a * left)))


@kernel
def share_along(columns, w, x_rows):
    """1 where a motion of the joints moves the hand along its twist, and 0 where it would leave it."""
    v, unit = _ZERO, scaled_six(w, 1.0 / size_of(w))
    for j in range(x_rows.shape[0]):
        v = add_column(v, columns, j, x_rows[j])
    along = dot_six(v, unit)
    if along <= 0.0:
        return 0.0
    beside = size_of((
        v[0] - along * unit[0], v[1] - along * unit[1], v[2] - along * unit[2],
        v[3] - along * unit[3], v[4] - along * unit[4], v[5] - along * unit[5],
    ))  # fmt: skip
    least, most = _BESIDE
    return min(max((most - beside / along) / (most - least), 0.0), 1.0)
