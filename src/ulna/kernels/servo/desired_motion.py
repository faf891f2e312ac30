"""Writes the objective of a tick: which joint velocities are desired, and how far others are from that.

It is |x - v|^2 for a command in joint space. For hands with twists w it is the sum of c |J x - w|^2, with c the weight of a
hand, and lambda |x - p|^2, with p the pull towards a posture: so p acts in the null space of all hands, and near a singularity
the damping keeps x short without hiding a way out of it.

A position is approached at the velocity v with v^2 / (2 a) + 4 h v = e, e being what is left and h the tick: far away that is the
greatest velocity from which a deceleration a stops in time, and near it an exponential approach without overshoot. With a limit
of jerk, h is longer by the m ticks of ``ramped_stop``, after which a velocity is reached: v' = (x - v) / h is damped critically.

J is that of where the arm is, so near a singularity x may lead past the place that is nearest to a pose, and back, without end.
Therefore no velocity is taken after which the arm would rest farther from the poses than after the certified stop
(``pose_squares``). From rest a tick moves so little that x always leads nearer, unless there is nothing nearer.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import add_column, column_dot, error_squares, load_six, pose_error, solve_damped, store_six
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.layout import IN_BASE
from ulna.kernels.servo.servo_layout import (
    ACCELERATION,
    DAMPING,
    END,
    FIRST,
    FRAME,
    GIVEN,
    GOAL,
    HAND_WIDTH,
    HANDS,
    LAG,
    LOWER,
    POSE,
    POSTURE,
    PULL,
    SPEED,
    UPPER,
    VELOCITY,
    WEIGHT,
)
from ulna.kernels.spatial.se3 import load_pose

_LOOKS = 4  # for joints at their limits
_AT_LIMIT = 0.01  # [rad or m]: a joint that is nearer to its limit is there
_LOST = 0.02  # what a singular value of J below it asks of the joints makes the others little slower
_APPROACH = 4.0  # ticks: the time constant near a position
SMALL = 1e-6  # [m/s, rad/s]: a slower desired motion counts as rest
_SHARE = 0.7  # of the acceleration, with which a position is approached


@kernel
def write_objective(mode, chains, goal_rows, limits, settings, q_rows, arrays):
    """Write H and f of the quadratic program, as x' H x / 2 - f' x.

    goal_rows: n_dof velocities or positions, or HAND_WIDTH numbers a hand; q_rows: where the arm is; chains: those of all hands,
    one after the other. arrays: H, f, J of each hand, the desired velocities or the twists of the hands, room for the damped
    system (``damped_system``).
    """
    h_rows, f_rows, jacobian_rows, desired_rows, system_rows = arrays
    n = f_rows.shape[0]
    if mode != HANDS:
        for j in range(n):
            x = goal_rows[j] if mode == VELOCITY else approach(goal_rows[j] - q_rows[j], limits, settings, j)
            desired_rows[j] = min(max(x, -limits[SPEED, j]), limits[SPEED, j])
            f_rows[j] = desired_rows[j]
            for k in range(n):
                h_rows[n * j + k] = 1.0 if j == k else 0.0
        return
    for j in range(n):
        f_rows[j] = 0.0
        for k in range(n):
            h_rows[n * j + k] = settings[DAMPING] if j == k else 0.0
    for i in range(goal_rows.shape[0] // HAND_WIDTH):
        hand, columns = goal_rows[HAND_WIDTH * i : HAND_WIDTH * (i + 1)], jacobian_rows[6 * n * i : 6 * n * (i + 1)]
        w = write_jacobian(hand, chains, limits, settings, q_rows, columns, system_rows)
        add_squares(columns, w, h_rows, f_rows)
        store_six(desired_rows, 6 * i, w)
    for j in range(n):
        pull = settings[PULL] * (limits[POSTURE, j] - q_rows[j]) if settings[PULL] > 0.0 else 0.0
        f_rows[j] += settings[DAMPING] * min(max(pull, -limits[SPEED, j]), limits[SPEED, j])


@kernel
def write_jacobian(hand, chains, limits, settings, q_rows, jacobian_rows, system_rows):
    """Write J of a hand, and return the twist that is desired of it: both times the square root of its weight."""
    frame = IN_BASE if hand[GIVEN] == POSE else int(hand[FRAME])
    end = chain_jacobian(chains[int(hand[FIRST]) : int(hand[END])], q_rows, frame, jacobian_rows, 6, 1)
    for j in range(q_rows.shape[0]):
        if limits[SPEED, j] == 0.0:  # it is held
            for k in range(6):
                jacobian_rows[6 * j + k] = 0.0
    w, rate, root = load_six(hand, GOAL), 1.0, sqrt(hand[WEIGHT])
    if hand[GIVEN] == POSE:
        w = pose_error(end, load_pose(hand[GOAL:], 0))
        rate = approach_rate(w, limits, settings, jacobian_rows, system_rows, q_rows)
    for k in range(jacobian_rows.shape[0]):
        jacobian_rows[k] *= root
    rate *= root
    return rate * w[0], rate * w[1], rate * w[2], rate * w[3], rate * w[4], rate * w[5]


@kernel
def add_squares(jacobian_rows, w, h_rows, f_rows):
    """Add J' J to H, and J' w to f."""
    n = f_rows.shape[0]
    for j in range(n):
        f_rows[j] += column_dot(jacobian_rows, j, w)
        for k in range(n):
            total = h_rows[n * j + k]
            for i in range(6):
                total += jacobian_rows[6 * j + i] * jacobian_rows[6 * k + i]
            h_rows[n * j + k] = total


@kernel
def approach(e, limits, settings, j):
    """The velocity at which entry j of q approaches a position that is e away."""
    a, lag = _SHARE * limits[ACCELERATION, j], _APPROACH * settings[LAG]
    v = min(a * (sqrt(lag * lag + 2.0 * abs(e) / a) - lag), limits[SPEED, j])
    return v if e >= 0.0 else -v


@kernel
def approach_rate(e, limits, settings, jacobian_rows, system_rows, q_rows):
    """The rate [1/s] at which a pose error is made smaller: the least of those of the joints that the error needs.

    A joint that would have to go beyond its limit is left out, and what the others need is computed without it: they would creep
    after what none of them can do.
    """
    n, free_rows, left_out = q_rows.shape[0], system_rows[N_SYSTEM:], True
    for k in range(6 * n):
        free_rows[k] = jacobian_rows[k]
    y = e
    for _ in range(_LOOKS):
        if left_out:
            y, left_out = solve_damped(free_rows, n, _LOST * _LOST, e, system_rows), False
            for j in range(n):
                way = column_dot(free_rows, j, y)
                left = limits[UPPER, j] - q_rows[j] if way > 0.0 else q_rows[j] - limits[LOWER, j]
                if left < min(abs(way), _AT_LIMIT):
                    left_out = True
                    for k in range(6):
                        free_rows[6 * j + k] = 0.0
    rate = 1.0 / (_APPROACH * settings[LAG])
    for j in range(n):
        way = column_dot(free_rows, j, y)
        if abs(way) > 1e-12:
            rate = min(rate, approach(abs(way), limits, settings, j) / abs(way))
    return rate


@kernel
def pose_squares(chains, goal_rows, q_rows):
    """The sum of c |e|^2 of all hands that are sent to a pose, e being the pose error where the arm is at q."""
    total = 0.0
    for i in range(goal_rows.shape[0] // HAND_WIDTH):
        hand = goal_rows[HAND_WIDTH * i : HAND_WIDTH * (i + 1)]
        if hand[GIVEN] == POSE:
            end = chain_pose(chains[int(hand[FIRST]) : int(hand[END])], q_rows)
            linear, angular = error_squares(pose_error(end, load_pose(hand[GOAL:], 0)))
            total += hand[WEIGHT] * (linear + angular)
    return total


@kernel
def missed(mode, goal_rows, jacobian_rows, desired_rows, x_rows):
    """How much of what is desired a velocity misses, as a share of the greatest: of all twists, or of the velocities."""
    n, miss, size = x_rows.shape[0], 0.0, SMALL
    if mode != HANDS:
        for j in range(n):
            miss, size = max(miss, abs(x_rows[j] - desired_rows[j])), max(size, abs(desired_rows[j]))
        return miss / size
    for hand in range(goal_rows.shape[0] // HAND_WIDTH):
        w, columns = load_six(desired_rows, 6 * hand), jacobian_rows[6 * n * hand : 6 * n * (hand + 1)]
        e, root = (-w[0], -w[1], -w[2], -w[3], -w[4], -w[5]), sqrt(goal_rows[HAND_WIDTH * hand + WEIGHT])
        for j in range(n):
            e = add_column(e, columns, j, x_rows[j])
        for i in range(6):
            miss, size = max(miss, abs(e[i]) / root), max(size, abs(w[i]) / root)
    return miss / size
