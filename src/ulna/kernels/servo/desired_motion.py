"""Writes the objective of a tick: which joint velocities are desired, and how far others are from that.

It is |x - v|^2 for a command in joint space, and |J x - w|^2 + lambda |x - p|^2 for a twist w, with p the pull towards a posture:
so p acts in the null space, and near a singularity the damping keeps x short without hiding a way out of it.

A position is approached at the velocity v with v^2 / (2 a) + 4 h v = e, e being what is left and h the tick: far away that is the
greatest velocity from which a deceleration a stops in time, and near it an exponential approach without overshoot.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.ik.damped_system import add_column, column_dot, load_six, pose_error, solve_damped, store_six
from ulna.kernels.layout import IN_BASE
from ulna.kernels.servo.servo_layout import ACCELERATION, DAMPING, POSE, POSITION, POSTURE, PULL, SPEED, TICK, VELOCITY
from ulna.kernels.spatial.se3 import load_pose

_APPROACH = 4.0  # ticks: the time constant near a position
SMALL = 1e-6  # [m/s, rad/s]: a slower desired motion counts as rest
_SHARE = 0.7  # of the acceleration, with which a position is approached


@kernel
def write_objective(mode, chain, expressed_in, goal, limits, settings, q_rows, arrays):
    """Write H and f of the quadratic program, as x' H x / 2 - f' x.

    goal: n_dof velocities or positions, a twist (6 numbers), or a pose (12 numbers); q_rows: where the arm is. arrays: H, f, J,
    the desired velocities, room for the damped system (``damped_system``).
    """
    h_rows, f_rows, jacobian_rows, desired_rows, system_rows = arrays
    n = f_rows.shape[0]
    if mode in (VELOCITY, POSITION):
        for j in range(n):
            x = goal[j] if mode == VELOCITY else approach(goal[j] - q_rows[j], limits, settings, j)
            desired_rows[j] = min(max(x, -limits[SPEED, j]), limits[SPEED, j])
            f_rows[j] = desired_rows[j]
            for k in range(n):
                h_rows[n * j + k] = 1.0 if j == k else 0.0
        return
    frame = IN_BASE if mode == POSE else expressed_in
    end = chain_jacobian(chain, q_rows, frame, jacobian_rows, 6, 1)
    w = load_six(goal, 0)
    if mode == POSE:
        e = pose_error(end, load_pose(goal, 0))
        rate = approach_rate(e, limits, settings, jacobian_rows, system_rows, n)
        w = rate * e[0], rate * e[1], rate * e[2], rate * e[3], rate * e[4], rate * e[5]
    for j in range(n):
        pull = settings[PULL] * (limits[POSTURE, j] - q_rows[j]) if settings[PULL] > 0.0 else 0.0
        f_rows[j] = column_dot(jacobian_rows, j, w) + settings[DAMPING] * min(max(pull, -limits[SPEED, j]), limits[SPEED, j])
        for k in range(n):
            total = settings[DAMPING] if j == k else 0.0
            for i in range(6):
                total += jacobian_rows[6 * j + i] * jacobian_rows[6 * k + i]
            h_rows[n * j + k] = total
    store_six(desired_rows, 0, w)


@kernel
def approach(e, limits, settings, j):
    """The velocity at which entry j of q approaches a position that is e away."""
    a, lag = _SHARE * limits[ACCELERATION, j], _APPROACH * settings[TICK]
    v = min(a * (sqrt(lag * lag + 2.0 * abs(e) / a) - lag), limits[SPEED, j])
    return v if e >= 0.0 else -v


@kernel
def approach_rate(e, limits, settings, jacobian_rows, system_rows, n):
    """The rate [1/s] at which a pose error is made smaller: the least of those of the joints that the error needs."""
    y = solve_damped(jacobian_rows, n, settings[DAMPING], e, system_rows)
    rate = 1.0 / (_APPROACH * settings[TICK])
    for j in range(n):
        way = column_dot(jacobian_rows, j, y)
        if abs(way) > 1e-12:
            rate = min(rate, approach(abs(way), limits, settings, j) / abs(way))
    return rate


@kernel
def missed(mode, jacobian_rows, desired_rows, x_rows):
    """How much of what is desired a velocity misses, as a share of it: of the twist, or of the velocities."""
    n, miss, size = x_rows.shape[0], 0.0, SMALL
    if mode in (VELOCITY, POSITION):
        for j in range(n):
            miss, size = max(miss, abs(x_rows[j] - desired_rows[j])), max(size, abs(desired_rows[j]))
        return miss / size
    e = -desired_rows[0], -desired_rows[1], -desired_rows[2], -desired_rows[3], -desired_rows[4], -desired_rows[5]
    for j in range(n):
        e = add_column(e, jacobian_rows, j, x_rows[j])
    for i in range(6):
        miss, size = max(miss, abs(e[i])), max(size, abs(desired_rows[i]))
    return miss / size
