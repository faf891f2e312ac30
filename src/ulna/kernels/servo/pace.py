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

    s^2 B / a + s lag B / |X| <= 1,    d = |X|^2 / B

the speed |s X| is at most sqrt(a d), which a deceleration of a / 2 brings down to zero in d, and near the end at most d / lag,
which is less where d is below a lag^2. Elsewhere the pace is 1, unless the twist asks for a greater acceleration than there is.

Hands with a twist that share a joint have one pace, the least of theirs. Hands that share none have each its own, by the joints
that move it. Beside a hand without a twist, a hand to whose twist little of X is due is slowed as little, unless it is near a
singularity: slowing it would not help the others.

Last, a hand is not followed where a unit of the joints moves it by too little along its twist, now and a little ahead: there the
arm is stretched, and joints to spare would turn for nothing. So the arm rests very near the end of its reach. On the way back
the hand moves more a little ahead, so that a twist the other way is followed at once. So it is with the pose of an only
hand: where it is out of reach, joints to spare would turn on for little. Of several hands one is nearly at its pose while the
joints still move for another.

Where the arm rests at a singularity, J leads nowhere along a twist, or of joints to spare the way to a dead end. So the arm is
pulled back the way it came, if that leads along the twist and X does not go there. The way is known by a place that the arm tows
behind it, as by a rope.

Source: the acceleration along a path is that of Bobrow, Dubowsky and Gibson (1985); slowing by the singular values is that of
Nakamura and Hanafusa (1986).
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.ik.damped_system import add_column, column_dot, load_six
from ulna.kernels.servo.desired_motion import SMALL, dot_six, scaled_six, size_of, weigh_jacobians, weighted, write_jacobians
from ulna.kernels.servo.objective import Program
from ulna.kernels.servo.quadratic_program import minimize, solve_on_rows

_AHEAD = 1e-4  # [rad or m]: how far the joint that moves farthest is ahead where the difference is taken
_SHARE, _LAG_TICKS = 0.7, 8.0  # of the acceleration, and ticks: nearer to the end than a lag^2 the approach is exponential
_SHARE_TO_POSE, _LAG_TICKS_TO_POSE = 1.0, 4.0  # of an only hand that goes to a pose: it need not stay on a line
_CLOSE = 0.025  # [rad or m]: the lag is longer where the end is farther than this
_WORTH = 1e-3, 2e-3  # [m/rad, or rad/rad]: where a unit of the joints moves a hand by less along its twist it rests; by more not
_SLOW = 1e-3, 2e-3  # [m/s, rad/s]: a twist that is slower than the first moves a hand whatever it is worth
_SOON = 0.05  # [rad or m]: so far ahead
_PART = 0.25  # of the steady motion: a hand is slowed in full that asks for more
_BESIDE = 0.01, 0.02  # of what is along a twist: with less beside it a hand follows, and with more it rests
_MIN_ALONG = 0.05  # of a twist: what is along it counts as so much here, since damping leaves little where an arm is stretched
_RATE = 1e3  # [1/s], at which a joint may come to its end, or a pair nearer
_STILL = 1e-9  # [rad/s or m/s]
_ROPE = 1.0  # [rad or m], of the joint that is farthest from the place that is towed
_BACK, _PULL = 0.2, 1e-2  # [rad or m a second], at which the arm is pulled, and the weight of that
_AGAINST = -0.3  # the cosine of an angle with the rope, beyond which the steady motion leads away
_LEADS = 0.01  # [m/rad, or rad/rad]: in the middle of the rope a unit of the joints moves the hand by more along its twist
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
        bound_rows[j] = -_RATE * max(q_rows[j] - limits[j].lower, 0.0)
        bound_rows[n + j] = -_RATE * max(limits[j].upper - q_rows[j], 0.0)
    for r in range(2 * n, bound_rows.shape[0]):
        bound_rows[r] = -_RATE * max(excess[r - 2 * n] - reserve, 0.0)


@routine
def write_steady(objective, program, m, steady):
    """Write the steady motion, which has the first m rows of the program; how many rows are active."""
    for i in range(objective.h_rows.shape[0]):
        steady.h_rows[i] = objective.h_rows[i]
    for j in range(objective.f_rows.shape[0]):
        steady.f_rows[j], steady.x_rows[j] = objective.f_rows[j], 0.0
    own = Program(
        program.box_rows, program.normal_rows, steady.bound_rows, steady.active_rows, steady.multiplier_rows, program.work_rows
    )
    return minimize(steady.h_rows, steady.f_rows, own, m, steady.x_rows)


@routine
def write_part(hands, objective, steady, program, k, across, hand):
    """Write what of the steady motion, of which k rows are active, is due to the twist of one of several hands."""
    n, w = steady.x_rows.shape[0], load_six(objective.desired_rows, 6 * hand)
    normal_rows, work_rows = program.normal_rows, program.work_rows
    columns = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
    v = weighted(w, w, 1.0 if hands[hand].is_pose else across)
    for a in range(k):
        steady.value_rows[a] = 0.0
    for j in range(n):
        steady.part_rows[j] = column_dot(columns, j, v)
    solve_on_rows(steady.h_rows, normal_rows, steady.active_rows, steady.value_rows, k, steady.part_rows, work_rows)


@routine
def write_changes(chains, hands, limits, q_rows, objective, steady):
    """Write how J of each hand changes along the steady motion; return the time [s] to where the difference is taken."""
    fastest = _STILL
    for j in range(q_rows.shape[0]):
        fastest = max(fastest, abs(steady.x_rows[j]))
    time = _AHEAD / fastest
    for j in range(q_rows.shape[0]):
        steady.ahead_rows[j] = q_rows[j] + time * steady.x_rows[j]
    write_jacobians(chains, hands, limits, steady.ahead_rows, steady.jacobian_rows)
    weigh_jacobians(hands, steady.jacobian_rows)
    for i in range(steady.jacobian_rows.shape[0]):
        steady.jacobian_rows[i] = (steady.jacobian_rows[i] - objective.jacobian_rows[i]) / time
    return time


@routine
def write_growth(hands, objective, steady, program, k, across):
    """Write y and z, with k active rows."""
    n, normal_rows, work_rows = steady.x_rows.shape[0], program.normal_rows, program.work_rows
    for j in range(n):
        steady.kept_rows[j], steady.lost_rows[j] = 0.0, 0.0
    for i in range(hands.shape[0]):
        columns, changes = objective.jacobian_rows[6 * n * i : 6 * n * (i + 1)], steady.jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        w, beside = load_six(objective.desired_rows, 6 * i), 1.0 if hands[i].is_pose else across
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
def write_pace(hands, limits, settings, objective, steady, across, least, hand):
    """Write the pace of a hand, and what slows it.

    least: the distance to the end of the reach that is reckoned with at least [rad or m]: gradients of pairs may jump.
    """
    n, root = steady.x_rows.shape[0], sqrt(hands[hand].weight)
    columns, w = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], load_six(objective.desired_rows, 6 * hand)
    changes, change, v = steady.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], _ZERO, _ZERO
    size, rate, growth, joint, found, pace, worth = 0.0, 0.0, 0.0, NOT_SLOWED, NOT_SLOWED, 1.0, 1.0
    for j in range(n):
        v, change = add_column(v, columns, j, steady.x_rows[j]), add_column(change, changes, j, steady.x_rows[j])
        if is_moved_by(columns, j):
            x, a = abs(steady.x_rows[j]), limits[j].acceleration
            grows = (abs(steady.kept_rows[j]) + abs(steady.lost_rows[j])) / a
            size, rate = max(size, x), max(rate, x / a)
            if grows > growth:
                growth, joint = grows, j
    if size > _STILL:
        is_free = hands.shape[0] == 1 and hands[hand].is_pose  # to leave its line
        pace = pace_of(size, rate, min(growth, rate * size / max(least, 1e-300)), settings, is_free)
        if across > 1.0 and (hands.shape[0] == 1 or not hands[hand].is_pose):
            worth = share_worth(v, change, w, size, root)
    pace *= worth
    if pace < 1.0:
        found = SINGULAR if size_of(v) < _SINGULAR * size * root else joint
    objective.pace_rows[hand], objective.slowing_rows[hand], objective.worth_rows[hand] = pace, found, worth


@kernel
def has_twist(hands, objective, hand):
    """Whether a hand has a twist that is not zero."""
    return not hands[hand].is_pose and size_of(load_six(objective.desired_rows, 6 * hand)) > SMALL


@kernel
def are_apart(hands, objective):
    """Whether some hands have a twist and others none. Hands that all go to poses share their joints by the squares."""
    n_twists = 0
    for i in range(hands.shape[0]):
        n_twists += 1 if has_twist(hands, objective, i) else 0
    return 0 < n_twists < hands.shape[0]


@routine
def share_paces(hands, objective):
    """Give hands with a twist that share a joint the least of their paces.

    So the joints move along the steady motion. If each hand had a pace of its own, the motion of a shared joint would turn where
    one hand comes to the end of its reach, and the other would pull it back and forth.
    """
    n_hands, n = hands.shape[0], objective.f_rows.shape[0]
    for _ in range(n_hands - 1):  # so the least pace gets from hand to hand
        for a in range(n_hands):
            for b in range(n_hands):
                if objective.pace_rows[b] < objective.pace_rows[a] and share_joint(hands, objective, n, a, b):
                    objective.pace_rows[a], objective.slowing_rows[a] = objective.pace_rows[b], objective.slowing_rows[b]


@kernel
def share_joint(hands, objective, n, a, b):
    """Whether two hands with a twist are moved by the same joint."""
    found = False
    if has_twist(hands, objective, a) and has_twist(hands, objective, b):
        for j in range(n):
            ours, theirs = objective.jacobian_rows[6 * n * a :], objective.jacobian_rows[6 * n * b :]
            found = found or (is_moved_by(ours, j) and is_moved_by(theirs, j))
    return found


@routine
def set_apart(limits, settings, state, objective, steady, hand):
    """Change the pace of one of several hands by the part of the steady motion that is due to it.

    It is slowed by no more than this is of the whole. And it grows only as the joints can accelerate: else a hand that is far
    behind its twist would pull the joints that it shares, faster than the others can make up for it.
    """
    n, rate, joint, size, whole = state.shape[0], 0.0, NOT_SLOWED, 0.0, _STILL
    columns, w = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], load_six(objective.desired_rows, 6 * hand)
    now, full = _ZERO, _ZERO
    for j in range(n):
        now, full = add_column(now, columns, j, state[j].qd), add_column(full, columns, j, steady.part_rows[j])
        size, whole = max(size, abs(steady.part_rows[j])), max(whole, abs(steady.x_rows[j]))
        if abs(steady.part_rows[j]) > rate * limits[j].acceleration:
            rate, joint = abs(steady.part_rows[j]) / limits[j].acceleration, j
    if objective.slowing_rows[hand] != SINGULAR:
        objective.pace_rows[hand] = 1.0 - (1.0 - objective.pace_rows[hand]) * min(1.0, size / (_PART * whole))
    most = dot_six(full, w)
    if most > SMALL * SMALL and rate > 0.0:
        pace = max(dot_six(now, w) / most, 0.0) + settings.lag / rate
        if pace < objective.pace_rows[hand]:
            objective.pace_rows[hand], objective.slowing_rows[hand] = pace, joint


@routine
def keep_on_line(hands, objective, steady, hand):
    """Let a hand with a twist rest where the steady motion would lead it off its line."""
    n, w = steady.x_rows.shape[0], load_six(objective.desired_rows, 6 * hand)
    if not hands[hand].is_pose and size_of(w) > SMALL:
        columns = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
        share = share_along(columns, w, steady.x_rows)
        objective.pace_rows[hand] *= share
        objective.worth_rows[hand] *= share


@kernel
def tow(state):
    """Move the place behind the arm, where the rope to it is taut."""
    length = rope_length(state)
    for j in range(state.shape[0] if length > _ROPE else 0):
        state[j].behind += (1.0 - _ROPE / length) * (state[j].q - state[j].behind)


@routine
def pull_of_way_back(chains, hands, limits, state, objective, steady):
    """The weight of a pull back the way the arm came: 0 unless a hand is at a singularity, and its twist leads there."""
    n, length, along_x, x_square, square, pull = state.shape[0], rope_length(state), 0.0, 0.0, 0.0, 0.0
    if length < _SOON:
        return 0.0
    for j in range(n):
        x, rope = steady.x_rows[j], state[j].behind - state[j].q
        steady.ahead_rows[j] = state[j].q + 0.5 * rope
        along_x, x_square, square = along_x + x * rope, x_square + x * x, square + rope * rope
    for hand in range(hands.shape[0]):
        is_lost = along_x < _AGAINST * sqrt(x_square * square) and objective.slowing_rows[hand] == SINGULAR
        if (objective.worth_rows[hand] < 1.0 or is_lost) and has_twist(hands, objective, hand):
            write_jacobians(chains, hands, limits, steady.ahead_rows, steady.jacobian_rows)
            weigh_jacobians(hands, steady.jacobian_rows)
            w, v = load_six(objective.desired_rows, 6 * hand), _ZERO
            columns = steady.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
            for j in range(n):
                v = add_column(v, columns, j, (state[j].behind - state[j].q) / length)
            if dot_six(v, w) > _LEADS * size_of(w) * sqrt(hands[hand].weight):
                if is_lost:
                    objective.pace_rows[hand], objective.worth_rows[hand] = 0.0, 0.0
                pull = max(pull, _PULL * (1.0 - objective.worth_rows[hand]))
    return pull


@kernel
def add_pull(state, objective, pull):
    """Add the pull back to the objective."""
    n, length = state.shape[0], rope_length(state)
    for j in range(n if pull > 0.0 else 0):
        objective.h_rows[n * j + j] += pull
        objective.f_rows[j] += pull * _BACK / length * (state[j].behind - state[j].q)


@kernel
def rope_length(state):
    """The greatest distance of an entry of q from the place behind the arm [rad or m]."""
    length = 0.0
    for j in range(state.shape[0]):
        length = max(length, abs(state[j].q - state[j].behind))
    return length


@kernel
def is_moved_by(columns, j):
    """Whether entry j of q moves a hand."""
    moves = 0.0
    for k in range(6):
        moves = max(moves, abs(columns[6 * j + k]))
    return moves > 0.0


@kernel
def pace_of(size, rate, growth, settings, is_free):
    """The pace: by the greatest |X|, and the greatest |X| and B by the accelerations of the joints."""
    if growth <= _STILL * rate:
        return 1.0
    share, ticks = (_SHARE_TO_POSE, _LAG_TICKS_TO_POSE) if is_free else (_SHARE, _LAG_TICKS)
    a, b = growth / share, max(sqrt(_CLOSE * rate / size), ticks * settings.lag) * growth / rate
    return min(1.0, 2.0 / (b + sqrt(b * b + 4.0 * a)))


@kernel
def share_worth(v, change, w, size, root):
    """0 where a unit of the joints moves a hand by too little along its twist, now and a little ahead, and 1 where it does not.

    v, change: how the hand moves by a motion of the joints, whose greatest velocity is ``size``, and how that changes. A hand
    with a slow twist, as near its pose, is not slowed: there the joints move for something else, such as the posture.
    """
    wanted, (least, most), (slow, fast) = size_of(w), _WORTH, _SLOW
    unit = scaled_six(w, 1.0 / max(wanted, SMALL))
    worth = (dot_six(v, unit) + max(dot_six(change, unit), 0.0) * _SOON / size) / (size * root)
    share = max((worth - least) / (most - least), (fast * root - wanted) / ((fast - slow) * root))
    return min(max(share, 0.0), 1.0)


@kernel
def share_along(columns, w, x_rows):
    """1 where a motion of the joints moves the hand along its twist, and 0 where it would leave it."""
    v, size = _ZERO, size_of(w)
    unit = scaled_six(w, 1.0 / size)
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
    return min(max((most - beside / max(along, _MIN_ALONG * size)) / (most - least), 0.0), 1.0)
