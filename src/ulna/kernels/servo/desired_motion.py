"""Writes the objective of a tick: the desired joint velocities, and the cost of others.

For a goal in joint space with velocities v it is |x - v|^2. For hands with twists w it is the sum of

    c |J x - w|^2 over all hands, and lambda |x - p|^2.

Here c is the weight of a hand, lambda the damping, and p the pull towards a posture. So p acts in the null space of all hands.
Near a singularity the damping keeps x short.

A position at a distance e is approached at the velocity v with v^2 / (2 a) + 4 T v = e. T is the time after which a desired
velocity is reached (``ServoSettings.lag``): one tick without a limit of jerk. Far away v is the greatest velocity from which a
deceleration a stops in time. Near the goal the approach is exponential, without overshoot. With a limit of jerk, T is longer by
the m ticks of ``ramped_stop``. The actual velocity y then follows v as y' = (v - y) / T, and near the goal this motion is
critically damped.

J belongs to the current configuration. So near a singularity x may lead past the configuration nearest to a pose, and back,
without end. Therefore a tick rejects velocities after which the arm would rest farther from the poses than after the braking
trajectory (``pose_squares``). From rest a tick moves so little that x always leads nearer, unless nothing is nearer.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import add_column, column_dot, error_squares, load_six, pose_error, solve_damped, store_six
from ulna.kernels.layout import IN_BASE
from ulna.kernels.servo.servo_records import HANDS, VELOCITY
from ulna.kernels.spatial.se3 import load_pose

_MAX_PASSES = 4  # over the joints, to leave out those at their limits
_AT_LIMIT = 0.01  # [rad or m]: a joint that is nearer to its limit counts as at its limit
_DAMPING_OF_APPROACH = 0.02  # smaller singular values of J hardly slow the other joints
_APPROACH_TICKS = 4.0  # ticks: time constant near a position
WEIGHT_ACROSS = 1e4  # weight of the error across a twist, relative to the error along it
MIN_TWIST = 1e-6  # [m/s, rad/s]: a slower desired motion counts as rest
_ACCELERATION_SHARE = 0.7  # share of the acceleration for the approach to a position


@kernel
def write_objective(chains, goal, limits, settings, q_rows, arrays):
    """Write H and f of the quadratic program, as x' H x / 2 - f' x.

    goal: A ``ServoGoal``. q_rows: The current configuration. chains: The chains of all hands, one after the other. arrays: An
    ``Objective``.
    """
    n = arrays.f_rows.shape[0]
    if goal.mode != HANDS:
        for j in range(n):
            x = goal.qd[j] if goal.mode == VELOCITY else approach(goal.q[j] - q_rows[j], limits, settings, j)
            arrays.desired_rows[j] = min(max(x, -limits[j].speed), limits[j].speed)
            arrays.f_rows[j] = arrays.desired_rows[j]
            for k in range(n):
                arrays.h_rows[n * j + k] = 1.0 if j == k else 0.0
        return
    hands = goal.hands
    write_jacobians(chains, hands, limits, q_rows, arrays.jacobian_rows)
    for i in range(hands.shape[0]):
        columns = arrays.jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        w, arrays.pace_rows[i] = desired_twist(hands[i], chains, limits, settings, q_rows, columns, arrays), 1.0
        store_six(arrays.desired_rows, 6 * i, scaled_six(w, sqrt(hands[i].weight)))
    weigh_jacobians(hands, arrays.jacobian_rows)
    write_squares(hands, settings, arrays, weight_across(hands, limits))
    write_pulls(limits, settings, q_rows, arrays)


@kernel
def weight_across(hands, limits):
    """Weight of the error across a twist; 1 if there are too few joints for all hands."""
    n_free = 0
    for j in range(limits.shape[0]):
        n_free += 1 if limits[j].speed > 0.0 else 0
    return WEIGHT_ACROSS if n_free >= 6 * hands.shape[0] else 1.0


@routine
def write_jacobians(chains, hands, limits, q_rows, jacobian_rows):
    """Write J of each hand; joints that are held have columns of zeros."""
    n = q_rows.shape[0]
    for i in range(hands.shape[0]):
        hand, columns = hands[i], jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        frame = IN_BASE if hand.is_pose else hand.frame
        chain_jacobian(chains[hand.first : hand.end], q_rows, frame, columns, 6, 1)
        for j in range(n):
            if limits[j].speed == 0.0:
                for k in range(6):
                    columns[6 * j + k] = 0.0


@kernel
def weigh_jacobians(hands, jacobian_rows):
    """Multiply J of each hand by the square root of its weight."""
    n_hands = hands.shape[0]
    width = jacobian_rows.shape[0] // max(n_hands, 1)
    for i in range(n_hands):
        root = sqrt(hands[i].weight)
        for k in range(width * i, width * (i + 1)):
            jacobian_rows[k] *= root


@kernel
def desired_twist(hand, chains, limits, settings, q_rows, jacobian_rows, arrays):
    """Desired twist of a hand: its goal, or a velocity towards its goal pose."""
    if not hand.is_pose:
        return load_six(hand.twist, 0)
    end = chain_pose(chains[hand.first : hand.end], q_rows)
    e = pose_error(end, load_pose(hand.pose, 0))
    return scaled_six(e, approach_rate(e, limits, settings, jacobian_rows, arrays.system_rows, arrays.free_rows, q_rows))


@kernel
def scaled_six(w, by):
    """Multiply six numbers by a number."""
    return by * w[0], by * w[1], by * w[2], by * w[3], by * w[4], by * w[5]


@routine
def write_squares(hands, settings, arrays, across):
    """Write the lower triangle of H: the damping, and J' M J of each hand.

    M weighs velocities across the twist by ``across``, and those along it by 1.
    """
    n = arrays.f_rows.shape[0]
    for j in range(n):
        for k in range(j + 1):
            arrays.h_rows[n * j + k] = settings.damping if j == k else 0.0
    for i in range(hands.shape[0]):
        w, columns = load_six(arrays.desired_rows, 6 * i), arrays.jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        beside = 1.0 if hands[i].is_pose else across
        for j in range(n):
            column = weighted(load_six(columns, 6 * j), w, beside)
            for k in range(j + 1):
                arrays.h_rows[n * j + k] += column_dot(columns, k, column)


@kernel
def write_pulls(limits, settings, q_rows, arrays):
    """Write f: the twists of the hands, each at its pace, and the pull towards the posture."""
    n = q_rows.shape[0]
    for j in range(n):
        pull = settings.pull * (limits[j].posture - q_rows[j]) if settings.pull > 0.0 else 0.0
        arrays.f_rows[j] = settings.damping * min(max(pull, -limits[j].speed), limits[j].speed)
    for i in range(arrays.pace_rows.shape[0]):
        w, columns = (
            scaled_six(load_six(arrays.desired_rows, 6 * i), arrays.pace_rows[i]),
            arrays.jacobian_rows[6 * n * i : 6 * n * (i + 1)],
        )
        for j in range(n):
            arrays.f_rows[j] += column_dot(columns, j, w)


@kernel
def weighted(v, w, across):
    """M v: multiply six numbers by a weight, except for their part along a twist w."""
    along = scaled_six(w, 1.0 / max(size_of(w), MIN_TWIST))
    less = (across - 1.0) * dot_six(v, along)
    return (
        across * v[0] - less * along[0], across * v[1] - less * along[1], across * v[2] - less * along[2],
        across * v[3] - less * along[3], across * v[4] - less * along[4], across * v[5] - less * along[5],
    )  # fmt: skip


@kernel
def dot_six(v, w):
    """Inner product of two vectors of six numbers."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3] + v[4] * w[4] + v[5] * w[5]


@kernel
def size_of(w):
    """Length of a vector of six numbers."""
    linear, angular = error_squares(w)
    return sqrt(linear + angular)


@kernel
def approach(e, limits, settings, j):
    """Velocity at which entry j of q approaches a position at a distance e."""
    v = min(speed_to_stop(abs(e), limits, settings, j), limits[j].speed)
    return v if e >= 0.0 else -v


@kernel
def speed_to_stop(way, limits, settings, j):
    """Speed from which entry j of q can stop within a distance, with a margin, whatever its limit of speed."""
    a, lag = _ACCELERATION_SHARE * limits[j].acceleration, _APPROACH_TICKS * settings.lag
    return a * (sqrt(lag * lag + 2.0 * way / a) - lag)


@kernel
def approach_rate(e, limits, settings, jacobian_rows, system_rows, free_rows, q_rows):
    """Rate [1/s] at which to reduce a pose error: the smallest rate of the joints that the error needs.

    A joint that would have to exceed its limit is left out, and the motion of the others is computed without it. Otherwise they
    would creep after an error that no joint can remove. free_rows: Scratch for 6 n_dof numbers.
    """
    n, left_out = q_rows.shape[0], True
    for k in range(6 * n):
        free_rows[k] = jacobian_rows[k]
    y = e
    for _ in range(_MAX_PASSES):
        if left_out:
            y, left_out = solve_damped(free_rows, n, _DAMPING_OF_APPROACH * _DAMPING_OF_APPROACH, e, system_rows), False
            for j in range(n):
                way = column_dot(free_rows, j, y)
                left = limits[j].upper - q_rows[j] if way > 0.0 else q_rows[j] - limits[j].lower
                if left < min(abs(way), _AT_LIMIT):
                    left_out = True
                    for k in range(6):
                        free_rows[6 * j + k] = 0.0
    rate = 1.0 / (_APPROACH_TICKS * settings.lag)
    for j in range(n):
        way = column_dot(free_rows, j, y)
        if abs(way) > 1e-12:
            rate = min(rate, approach(abs(way), limits, settings, j) / abs(way))
    return rate


@kernel
def pose_squares(chains, hands, q_rows):
    """Sum of c |e|^2 over all hands with a goal pose; e is the pose error at q."""
    total = 0.0
    for i in range(hands.shape[0]):
        hand = hands[i]
        if hand.is_pose:
            end = chain_pose(chains[hand.first : hand.end], q_rows)
            linear, angular = error_squares(pose_error(end, load_pose(hand.pose, 0)))
            total += hand.weight * (linear + angular)
    return total


@kernel
def relative_error(goal, jacobian_rows, desired_rows, x_rows):
    """Largest error of a velocity, relative to the largest desired twist component or joint velocity."""
    n, miss, size = x_rows.shape[0], 0.0, MIN_TWIST
    if goal.mode != HANDS:
        for j in range(n):
            miss, size = max(miss, abs(x_rows[j] - desired_rows[j])), max(size, abs(desired_rows[j]))
        return miss / size
    for hand in range(goal.hands.shape[0]):
        w, columns = load_six(desired_rows, 6 * hand), jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
        e, root = (-w[0], -w[1], -w[2], -w[3], -w[4], -w[5]), sqrt(goal.hands[hand].weight)
        for j in range(n):
            e = add_column(e, columns, j, x_rows[j])
        for i in range(6):
            miss, size = max(miss, abs(e[i]) / root), max(size, abs(w[i]) / root)
    return miss / size
