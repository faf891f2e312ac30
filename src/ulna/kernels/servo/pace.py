"""Computes the pace of a hand: the share of its twist with which the arm can brake before a singularity.

Let X be the joint velocities that follow the twists w in full, however fast: the *steady motion*. It is the solution of the
quadratic program without limits of velocity and acceleration, but with joint limits and near pairs. So H X = J^T M w. Here H is
J^T M J plus the damping, and M weighs errors along and across a twist. The arm shall move at s X, where s is the pace.

As the arm moves along X, its Jacobian changes by J'. J' is a finite difference of J between here and a configuration a little
ahead. X changes by z - y, on the active constraints, where

    H y = J^T M (J' X),    H z = J'^T M (w - J X)

If a near pair is active, its gradient g changes by g'. Its multiplier times g' is added to the right side of z, and y satisfies
g^T y = g'^T X. y is the acceleration that keeps the hand's velocity while J changes. z is the velocity change due to the damping.

Near the end of the reach, |y| + |z| gives the distance d from it in joint space. Consider one joint whose column of J is k d,
with a constant k. There |X|^2 / (|y| + |z|) = d, however small d is. With B = |y| + |z|, the acceleration a of the joints and a
time constant ``lag`` [s] of several ticks, the pace satisfies

    s^2 B / a + s lag B / |X| <= 1,    d = |X|^2 / B

The speed |s X| is then at most sqrt(a d). A deceleration of a / 2 brings it to zero within d. Very near the end, where d is below
a lag^2, the smaller bound d / lag holds. Elsewhere the pace is 1, unless the twist needs more acceleration than the joints have.

Hands with twists that share a joint have one pace, the smallest of theirs. Hands without a common joint each have their own,
computed from the joints that move them. If some hands have no twist, a hand with little influence on X is slowed less, unless it
is near a singularity. Slowing it more would not help the others.

A hand rests where a unit of joint motion moves it by too little along its twist, now and a little ahead. The arm is stretched
there, and null-space motion would be useless. So the arm rests very near the end of its reach. On the way back a unit of joint
motion moves the hand more in the configuration a little ahead. So the arm follows an opposite twist at once. The same holds for
the pose of a single hand. If it is out of reach, redundant joints would move on for little gain. With several hands one may be
nearly at its pose while the joints move for another.

If the arm rests at a singularity, J does not show the way back, or shows a null-space motion to a dead end. So a
pull leads the arm back along the path by which it came. It acts if that path leads along the twist and X does not go there. The
path is known by a configuration that the arm tows behind it, as by a rope.

Sources: Bobrow, Dubowsky and Gibson (1985) for the acceleration along a path; Nakamura and Hanafusa (1986) for slowing down by
singular values.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.ik.damped_system import add_column, column_dot, load_six
from ulna.kernels.servo.desired_motion import MIN_TWIST, dot_six, scaled_six, size_of, weigh_jacobians, weighted, write_jacobians
from ulna.kernels.servo.objective import Program
from ulna.kernels.servo.quadratic_program import minimize, solve_on_rows

_DIFFERENCE_STEP = 1e-4  # [rad or m]: finite difference, of the joint that moves farthest
_ACCELERATION_SHARE, _LAG_TICKS = 0.7, 8.0  # of the acceleration; nearer to the end than a lag^2 the approach is exponential
_ACCELERATION_SHARE_TO_POSE, _LAG_TICKS_TO_POSE = 1.0, 4.0  # of a single hand with a goal pose: it need not stay on a line
_LONG_LAG_DISTANCE = 0.025  # [rad or m]: the lag is longer at greater distances from the end
_PROGRESS = 1e-3, 2e-3  # [m/rad, or rad/rad]: hand motion along the twist per joint motion: below, the hand rests
_SLOW_TWIST = 1e-3, 2e-3  # [m/s, rad/s]: a twist slower than the first moves a hand in any case
_LOOK_AHEAD = 0.05  # [rad or m]: distance of "a little ahead"
_FULL_PART = 0.25  # of the steady motion: a hand that causes more is slowed in full
_DEVIATION = 0.01, 0.02  # velocity across a twist per velocity along it: below, a hand follows; above, it rests
_MIN_ALONG = 0.05  # of a twist: smallest velocity along it for this ratio, since damping leaves little near a singularity
_BOUND_RATE = 1e3  # [1/s], at which a joint may approach its limit, or a pair its clearance
_MIN_SPEED = 1e-9  # [rad/s or m/s]
_ROPE_LENGTH = 1.0  # [rad or m], of the joint farthest from the towed configuration
_RETURN_SPEED, _RETURN_WEIGHT = 0.2, 1e-2  # speed [rad/s or m/s] and weight of the pull back
_MIN_COSINE = -0.3  # of the angle with the rope: below, the steady motion leads away
_MIN_RETURN_PROGRESS = 0.01  # [m/rad, or rad/rad]: hand motion along the twist per joint motion, mid-rope
_SINGULAR = 0.1  # [m/rad, or rad/rad]: smaller motion of the hand along its twist per joint motion counts as singular
MIN_DISTANCE = 4e-3  # [rad or m]: smallest distance to the end of the reach while pairs are active
NOT_SLOWED, SINGULAR = -2, -1
_ZERO = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def write_steady_bounds(limits, q_rows, excess, reserve, bound_rows):
    """Write the bounds of the steady motion, first of the joint limits, then of the near pairs.

    excess: The distance of each pair beyond its clearance [m]; ``reserve`` is subtracted. A bound acts only very near a limit: it
    does not limit velocities, which would hide how X grows.
    """
    n = q_rows.shape[0]
    for j in range(n):
        bound_rows[j] = -_BOUND_RATE * max(q_rows[j] - limits[j].lower, 0.0)
        bound_rows[n + j] = -_BOUND_RATE * max(limits[j].upper - q_rows[j], 0.0)
    for r in range(2 * n, bound_rows.shape[0]):
        bound_rows[r] = -_BOUND_RATE * max(excess[r - 2 * n] - reserve, 0.0)


@routine
def write_steady(objective, program, m, steady):
    """Write the steady motion under the first m constraints of the program; return the number of active ones."""
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
    """Write the part of the steady motion, with k active constraints, that the twist of one hand causes."""
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
    """Write the derivative of each hand's J along the steady motion.

    Return the time [s] to the configuration of the finite difference.
    """
    fastest = _MIN_SPEED
    for j in range(q_rows.shape[0]):
        fastest = max(fastest, abs(steady.x_rows[j]))
    time = _DIFFERENCE_STEP / fastest
    for j in range(q_rows.shape[0]):
        steady.ahead_rows[j] = q_rows[j] + time * steady.x_rows[j]
    write_jacobians(chains, hands, limits, steady.ahead_rows, steady.jacobian_rows)
    weigh_jacobians(hands, steady.jacobian_rows)
    for i in range(steady.jacobian_rows.shape[0]):
        steady.jacobian_rows[i] = (steady.jacobian_rows[i] - objective.jacobian_rows[i]) / time
    return time


@routine
def write_growth(hands, objective, steady, program, k, across):
    """Write y and z, with k active constraints."""
    n, normal_rows, work_rows = steady.x_rows.shape[0], program.normal_rows, program.work_rows
    for j in range(n):
        steady.growth_rows[j], steady.damping_rows[j] = 0.0, 0.0
    for i in range(hands.shape[0]):
        columns, changes = objective.jacobian_rows[6 * n * i : 6 * n * (i + 1)], steady.jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        w, beside = load_six(objective.desired_rows, 6 * i), 1.0 if hands[i].is_pose else across
        change, left = _ZERO, w
        for j in range(n):
            change, left = add_column(change, changes, j, steady.x_rows[j]), add_column(left, columns, j, -steady.x_rows[j])
        change, left = weighted(change, w, beside), weighted(left, w, beside)
        for j in range(n):
            steady.growth_rows[j] += column_dot(columns, j, change)
            steady.damping_rows[j] += column_dot(changes, j, left)
    for a in range(k):
        steady.value_rows[a] = 0.0
        for j in range(n):
            steady.damping_rows[j] += steady.multiplier_rows[a] * steady.turn_rows[n * a + j]
    solve_on_rows(steady.h_rows, normal_rows, steady.active_rows, steady.value_rows, k, steady.damping_rows, work_rows)
    for a in range(k):
        steady.value_rows[a] = 0.0
        for j in range(n):
            steady.value_rows[a] += steady.turn_rows[n * a + j] * steady.x_rows[j]
    solve_on_rows(steady.h_rows, normal_rows, steady.active_rows, steady.value_rows, k, steady.growth_rows, work_rows)


@routine
def write_pace(hands, limits, settings, objective, steady, across, least, hand):
    """Write the pace of a hand, and the cause that slows it.

    least: The smallest distance to the end of the reach to compute with [rad or m], because gradients of pairs may jump.
    """
    n, root = steady.x_rows.shape[0], sqrt(hands[hand].weight)
    columns, w = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], load_six(objective.desired_rows, 6 * hand)
    changes, change, v = steady.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], _ZERO, _ZERO
    size, rate, growth, joint, found, pace, progress = 0.0, 0.0, 0.0, NOT_SLOWED, NOT_SLOWED, 1.0, 1.0
    for j in range(n):
        v, change = add_column(v, columns, j, steady.x_rows[j]), add_column(change, changes, j, steady.x_rows[j])
        if is_moved_by(columns, j):
            x, a = abs(steady.x_rows[j]), limits[j].acceleration
            grows = (abs(steady.growth_rows[j]) + abs(steady.damping_rows[j])) / a
            size, rate = max(size, x), max(rate, x / a)
            if grows > growth:
                growth, joint = grows, j
    if size > _MIN_SPEED:
        is_free = hands.shape[0] == 1 and hands[hand].is_pose  # may leave its line
        pace = pace_of(size, rate, min(growth, rate * size / max(least, 1e-300)), settings, is_free)
        if across > 1.0 and (hands.shape[0] == 1 or not hands[hand].is_pose):
            progress = progress_share(v, change, w, size, root)
    pace *= progress
    if pace < 1.0:
        found = SINGULAR if size_of(v) < _SINGULAR * size * root else joint
    objective.pace_rows[hand], objective.slowing_rows[hand], objective.progress_rows[hand] = pace, found, progress


@kernel
def has_twist(hands, objective, hand):
    """Whether a hand has a nonzero twist."""
    return not hands[hand].is_pose and size_of(load_six(objective.desired_rows, 6 * hand)) > MIN_TWIST


@kernel
def some_have_twists(hands, objective):
    """Whether some hands have a twist and others have none.

    Hands that all go to poses share their joints by least squares.
    """
    n_twists = 0
    for i in range(hands.shape[0]):
        n_twists += 1 if has_twist(hands, objective, i) else 0
    return 0 < n_twists < hands.shape[0]


@routine
def share_paces(hands, objective):
    """Give hands with a twist that share a joint the smallest of their paces.

    So the joints move along the steady motion. With separate paces a shared joint would turn back where one hand reaches the end
    of its reach. The other hand would then pull it back and forth.
    """
    n_hands, n = hands.shape[0], objective.f_rows.shape[0]
    for _ in range(n_hands - 1):  # passes the smallest pace from hand to hand
        for a in range(n_hands):
            for b in range(n_hands):
                if objective.pace_rows[b] < objective.pace_rows[a] and share_joint(hands, objective, n, a, b):
                    objective.pace_rows[a], objective.slowing_rows[a] = objective.pace_rows[b], objective.slowing_rows[b]


@kernel
def share_joint(hands, objective, n, a, b):
    """Whether the same joint moves two hands with a twist."""
    found = False
    if has_twist(hands, objective, a) and has_twist(hands, objective, b):
        for j in range(n):
            ours, theirs = objective.jacobian_rows[6 * n * a :], objective.jacobian_rows[6 * n * b :]
            found = found or (is_moved_by(ours, j) and is_moved_by(theirs, j))
    return found


@routine
def set_own_pace(limits, settings, state, objective, steady, hand):
    """Adapt the pace of one of several hands to its part of the steady motion.

    The hand is slowed only in proportion to this part. And its pace grows only as the joints can accelerate. Otherwise a hand far
    behind its twist would pull shared joints faster than the other hands can compensate.
    """
    n, rate, joint, size, whole = state.shape[0], 0.0, NOT_SLOWED, 0.0, _MIN_SPEED
    columns, w = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)], load_six(objective.desired_rows, 6 * hand)
    now, full = _ZERO, _ZERO
    for j in range(n):
        now, full = add_column(now, columns, j, state[j].qd), add_column(full, columns, j, steady.part_rows[j])
        size, whole = max(size, abs(steady.part_rows[j])), max(whole, abs(steady.x_rows[j]))
        if abs(steady.part_rows[j]) > rate * limits[j].acceleration:
            rate, joint = abs(steady.part_rows[j]) / limits[j].acceleration, j
    if objective.slowing_rows[hand] != SINGULAR:
        objective.pace_rows[hand] = 1.0 - (1.0 - objective.pace_rows[hand]) * min(1.0, size / (_FULL_PART * whole))
    most = dot_six(full, w)
    if most > MIN_TWIST * MIN_TWIST and rate > 0.0:
        pace = max(dot_six(now, w) / most, 0.0) + settings.lag / rate
        if pace < objective.pace_rows[hand]:
            objective.pace_rows[hand], objective.slowing_rows[hand] = pace, joint


@routine
def keep_on_line(hands, objective, steady, hand):
    """Slow a hand with a twist to rest where the steady motion would lead it off its line."""
    n, w = steady.x_rows.shape[0], load_six(objective.desired_rows, 6 * hand)
    if not hands[hand].is_pose and size_of(w) > MIN_TWIST:
        columns = objective.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
        share = share_along(columns, w, steady.x_rows)
        objective.pace_rows[hand] *= share
        objective.progress_rows[hand] *= share


@kernel
def tow(state):
    """Move the towed configuration behind the arm, if the rope to it is taut."""
    length = rope_length(state)
    for j in range(state.shape[0] if length > _ROPE_LENGTH else 0):
        state[j].behind += (1.0 - _ROPE_LENGTH / length) * (state[j].q - state[j].behind)


@routine
def return_weight(chains, hands, limits, state, objective, steady):
    """Weight of the pull back along the path; 0 unless a hand is at a singularity."""
    n, length, along_x, x_square, square, pull = state.shape[0], rope_length(state), 0.0, 0.0, 0.0, 0.0
    if length < _LOOK_AHEAD:
        return 0.0
    for j in range(n):
        x, rope = steady.x_rows[j], state[j].behind - state[j].q
        steady.ahead_rows[j] = state[j].q + 0.5 * rope
        along_x, x_square, square = along_x + x * rope, x_square + x * x, square + rope * rope
    for hand in range(hands.shape[0]):
        is_lost = along_x < _MIN_COSINE * sqrt(x_square * square) and objective.slowing_rows[hand] == SINGULAR
        if (objective.progress_rows[hand] < 1.0 or is_lost) and has_twist(hands, objective, hand):
            write_jacobians(chains, hands, limits, steady.ahead_rows, steady.jacobian_rows)
            weigh_jacobians(hands, steady.jacobian_rows)
            w, v = load_six(objective.desired_rows, 6 * hand), _ZERO
            columns = steady.jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
            for j in range(n):
                v = add_column(v, columns, j, (state[j].behind - state[j].q) / length)
            if dot_six(v, w) > _MIN_RETURN_PROGRESS * size_of(w) * sqrt(hands[hand].weight):
                if is_lost:
                    objective.pace_rows[hand], objective.progress_rows[hand] = 0.0, 0.0
                pull = max(pull, _RETURN_WEIGHT * (1.0 - objective.progress_rows[hand]))
    return pull


@kernel
def add_return_pull(state, objective, pull):
    """Add the pull back along the path to the objective."""
    n, length = state.shape[0], rope_length(state)
    for j in range(n if pull > 0.0 else 0):
        objective.h_rows[n * j + j] += pull
        objective.f_rows[j] += pull * _RETURN_SPEED / length * (state[j].behind - state[j].q)


@kernel
def rope_length(state):
    """Largest difference of an entry of q from the towed configuration [rad or m]."""
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
    """Pace of a hand.

    size: The largest |X|. rate, growth: The largest |X| and B, divided by the accelerations of the joints.
    """
    if growth <= _MIN_SPEED * rate:
        return 1.0
    share, ticks = (_ACCELERATION_SHARE_TO_POSE, _LAG_TICKS_TO_POSE) if is_free else (_ACCELERATION_SHARE, _LAG_TICKS)
    a, b = growth / share, max(sqrt(_LONG_LAG_DISTANCE * rate / size), ticks * settings.lag) * growth / rate
    return min(1.0, 2.0 / (b + sqrt(b * b + 4.0 * a)))


@kernel
def progress_share(v, change, w, size, root):
    """Share, 0 to 1, to which a hand is moved along its twist.

    It is 0 where a unit of joint motion moves the hand by too little along its twist, now and a little ahead. A hand with a slow
    twist, as near its pose, is not slowed: there the joints move for another purpose, such as the posture. v, change: Velocity of
    the hand by a joint motion, and its derivative. size: The largest joint velocity of this motion.
    """
    wanted, (least, most), (slow, fast) = size_of(w), _PROGRESS, _SLOW_TWIST
    unit = scaled_six(w, 1.0 / max(wanted, MIN_TWIST))
    progress = (dot_six(v, unit) + max(dot_six(change, unit), 0.0) * _LOOK_AHEAD / size) / (size * root)
    share = max((progress - least) / (most - least), (fast * root - wanted) / ((fast - slow) * root))
    return min(max(share, 0.0), 1.0)


@kernel
def share_along(columns, w, x_rows):
    """1 where a joint motion moves the hand along its twist, and 0 where the hand would leave its line."""
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
    least, most = _DEVIATION
    return min(max((most - beside / max(along, _MIN_ALONG * size)) / (most - least), 0.0), 1.0)
