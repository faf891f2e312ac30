"""Computes a tick of constant jerk and the braking trajectory after it, which limits the jerk too.

In a tick of length h the acceleration changes linearly from a to a', so that with constant jerk

    v' = v + h (a + a') / 2,    q' = q + h v + h^2 (2 a + a') / 6.

The stop after it has three parts and takes n ticks, the same for all joints. Let m be the number of ticks in which each joint can
ramp up to its maximum acceleration within its limit of jerk.

1. Bend: in 2 m ticks the acceleration changes linearly from a' to -A.
2. Constant deceleration: it is -A for n - 3 m ticks.
3. Ramp down: in m ticks it changes linearly from -A to 0.

The velocity is 0 at the end for

    A = x / (h (n - 1.5 m)),    x = v' + a' m h.

x is the velocity that remains if the acceleration ramps down to 0 in the bend, with A = 0. After the bend all joints share one
time profile, so q moves on a straight line. With r ticks left, for r >= m and then for r < m,

    v = A h (r - m / 2),      to go: A h^2 ((r - m) r / 2 + m^2 / 6);
    v = A h r^2 / (2 m),      to go: A h^2 r^3 / (6 m).

All of this is linear in x, as a stop of constant deceleration is in v': q rests at ``rest_of_zero_velocity`` +
``ramped_travel_per_velocity`` x. So for each n the x that keep all limits at all times are a box (``write_box_of_ramped_stop``):

- An acceleration that changes linearly in time stays between its values at the ends of the tick or part. So only these are
  bounded.
- In the bend, of duration T = 2 m h, velocity and position are between their Bernstein coefficients. Those of the velocity are
  v', x and its value at the end. Those of the position are the following, and its value at the end:

      q',    q' + v' T / 3,    q' + 2 v' T / 3 + a' T^2 / 6.
- The jerk of the bend is at most 2 A_max / (2 m h), which is the limit.

A state that keeps these limits keeps them in the next tick too, for any x of that tick. The reason: the Bernstein coefficients of
a part of a polynomial are between those of the whole. Source: Farin, Curves and Surfaces for CAGD, 5th ed., chapter 5.
"""

from ulna.engine.decorators import kernel, routine
from ulna.kernels.servo.servo_records import LIMITED_BY_ACCELERATION, LIMITED_BY_JERK, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY

ROUNDING = 1e-9  # relative rounding of numbers of ticks and of limits
POSITION_ROUNDING = 1e-12  # [rad or m]: rounding may put a position beyond a limit by this


@kernel
def velocity_left(state, settings, j):
    """Velocity x of entry j that remains if the acceleration ramps down to 0."""
    return state[j].qd + state[j].qdd * settings.ramp * settings.period


@kernel
def acceleration_after(x, state, settings, j):
    """Acceleration a' of entry j at the end of the tick after which x is left."""
    h = settings.period
    return (x - state[j].qd - 0.5 * h * state[j].qdd) / (h * (0.5 + settings.ramp))


@kernel
def deceleration(x, settings, n):
    """Deceleration A of a stop of n ticks, n > 0."""
    return x / (settings.period * (n - 1.5 * settings.ramp))


@routine
def write_ramped_tick(x_rows, state, limits, settings, after):
    """Write the state after a tick with given x, and the stop from there; return its ticks.

    after: Has the shape of the state.
    """
    h = settings.period
    for j in range(x_rows.shape[0]):
        a, b = state[j].qdd, acceleration_after(x_rows[j], state, settings, j)
        after[j].q = state[j].q + h * (state[j].qd + h * (2.0 * a + b) / 6.0)
        after[j].qd, after[j].qdd = state[j].qd + 0.5 * h * (a + b), b
    return write_ramped_stop(after, limits, settings)


@kernel
def write_ramped_stop(state, limits, settings):
    """Write the stop that begins at a state; return its number of ticks."""
    h, m, most, moves = settings.period, settings.ramp, 0.0, False
    for j in range(state.shape[0]):
        moves = moves or state[j].qd != 0.0 or state[j].qdd != 0.0
        most = max(most, abs(velocity_left(state, settings, j)) / (limits[j].acceleration * h))
    steady = int(max(most - 1.5 * m, 0.0))
    steady = steady if most - 1.5 * m <= steady + ROUNDING * most else steady + 1
    n = steady + 3 * int(m) if moves else 0
    bend = 2.0 * m * h
    for j in range(state.shape[0]):
        v, a = state[j].qd, state[j].qdd
        state[j].start_qd, state[j].start_q, state[j].start_qdd, state[j].rest_q = v, state[j].q, a, state[j].q
        if moves:
            most = deceleration(velocity_left(state, settings, j), settings, n)
            state[j].rest_q += bend * (v + a * bend / 3.0) + rest_per_deceleration(settings, n) * most
    return n


@routine
def ramped_stop_is_within_limits(state, limits, settings, n):
    """Whether a state and its stop of n ticks keep all limits."""
    bend, good = 2.0 * settings.ramp * settings.period, True
    for j in range(state.shape[0]):
        q, v, a, x = state[j].start_q, state[j].start_qd, state[j].start_qdd, velocity_left(state, settings, j)
        speed, most = limits[j].speed, limits[j].acceleration
        good = good and abs(a) <= most * (1.0 + ROUNDING) and max(abs(v), abs(x)) <= speed * (1.0 + ROUNDING) + POSITION_ROUNDING
        low, high = min(q, state[j].rest_q), max(q, state[j].rest_q)
        if n > 0:
            ahead, later = q + v * bend / 3.0, q + bend * (2.0 * v / 3.0 + a * bend / 6.0)
            end = q + bend * (v + a * bend / 3.0) - deceleration(x, settings, n) * bend * bend / 6.0
            low, high = min(low, ahead, later, end), max(high, ahead, later, end)
        good = good and limits[j].lower - POSITION_ROUNDING <= low and high <= limits[j].upper + POSITION_ROUNDING
    return good


@kernel
def ramped_state(state, settings, n, k, j):
    """Position, velocity and acceleration of entry j after k ticks of a stop of n, 0 <= k <= n."""
    h, m, left = settings.period, settings.ramp, n - k
    rate, onset = state[j].start_qd, state[j].start_qdd
    most = deceleration(rate + onset * m * h, settings, n)
    if left == 0:
        return state[j].rest_q, 0.0, 0.0
    if k <= 2 * m:
        t, a = k * h, onset - (onset + most) * k / (2.0 * m)
        return state[j].start_q + t * (rate + t * (2.0 * onset + a) / 6.0), rate + 0.5 * t * (onset + a), a
    if left >= m:
        to_go = most * h * h * (0.5 * (left - m) * left + m * m / 6.0)
        return state[j].rest_q - to_go, most * h * (left - 0.5 * m), -most
    return state[j].rest_q - most * h * h * left**3 / (6.0 * m), most * h * left * left / (2.0 * m), -most * left / m


@kernel
def bend_state(state, settings, n, before, t, j):
    """Position and acceleration of entry j at a time t in the bend of a stop of n ticks.

    A negative t is in the tick before the bend. before: The acceleration at the beginning of that tick.
    """
    h, m, onset = settings.period, settings.ramp, state[j].start_qdd
    most = deceleration(state[j].start_qd + onset * m * h, settings, n)
    jerk = -(onset + most) / (2.0 * m * h) if t > 0.0 else (onset - before) / h
    return state[j].start_q + t * (state[j].start_qd + t * (0.5 * onset + t * jerk / 6.0)), onset + t * jerk


@kernel
def velocity_left_after_tick(state, counters, settings, j):
    """Velocity x of entry j after one more tick of the braking trajectory."""
    n, k = counters.ticks, counters.done + 1
    if k >= n:
        return 0.0
    _, v, a = ramped_state(state, settings, n, k, j)
    return v + a * settings.ramp * settings.period


@kernel
def continue_ramped_stop(state, counters, settings):
    """Write the state after one more tick of the braking trajectory, n > 0."""
    n, k = counters.ticks, counters.done + 1
    for j in range(state.shape[0]):
        state[j].q, state[j].qd, state[j].qdd = ramped_state(state, settings, n, k, j)


@kernel
def changes_per_acceleration(settings):
    """Derivatives of q', of v', and of the rest position without A, with respect to a'."""
    h, bend = settings.period, 2.0 * settings.ramp * settings.period
    return h * h / 6.0, 0.5 * h, h * h / 6.0 + 0.5 * h * bend + bend * bend / 3.0


@kernel
def rest_per_deceleration(settings, n):
    """Derivative of the rest position after a stop of n ticks with respect to A."""
    h, m = settings.period, settings.ramp
    steady = n - 3.0 * m
    return 0.5 * h * h * (steady * (steady + m) - m * m)


@kernel
def ramped_travel_per_velocity(settings, n):
    """Derivative of the rest position, after a tick and a stop of n ticks, with respect to x [s]."""
    _, _, way = changes_per_acceleration(settings)
    return way / (settings.period * (0.5 + settings.ramp)) + rest_per_deceleration(settings, n) * deceleration(1.0, settings, n)


@kernel
def rest_of_zero_velocity(state, settings, j):
    """Position where entry j rests after a tick with x = 0."""
    h, bend = settings.period, 2.0 * settings.ramp * settings.period
    _, _, way = changes_per_acceleration(settings)
    v, a = state[j].qd, state[j].qdd
    aside = h * (v + h * a / 3.0) + bend * (v + 0.5 * h * a)
    return state[j].q + aside + way * acceleration_after(0.0, state, settings, j)


@kernel
def ramped_travel(state, after, settings, n, j):
    """Upper bound of the travel of entry j in a tick and its stop of n ticks.

    Movements back and forth are added. It is exact if the joint never turns back. The integral of the magnitude of a polynomial
    is at most the mean magnitude of its Bernstein coefficients, times its duration.
    """
    h, m, v, before, x = settings.period, settings.ramp, after[j].qd, state[j].qd, velocity_left(after, settings, j)
    most, line = deceleration(x, settings, n), n - 3.0 * m
    in_tick = abs(before) + abs(before + 0.5 * h * state[j].qdd) + abs(v)
    in_bend = abs(v) + abs(x) + abs(most * h * (line + 0.5 * m))
    return (h * in_tick + 2.0 * m * h * in_bend) / 3.0 + abs(most) * h * h * (0.5 * line * (line + m) + m * m / 6.0)


@kernel
def ramped_limit_reached(x, state, limits, settings, n, j):
    """Status of the limit that x of entry j has reached, at the border of its box."""
    h, most, before = settings.period, limits[j].acceleration, state[j].qdd
    a, speed = acceleration_after(x, state, settings, j), limits[j].speed * (1.0 - 1e-9)
    if max(abs(x), abs(state[j].qd + 0.5 * h * (before + a))) >= speed:
        return LIMITED_BY_VELOCITY
    if max(abs(a), abs(deceleration(x, settings, n))) >= most * (1.0 - 1e-6):
        return LIMITED_BY_ACCELERATION
    return LIMITED_BY_JERK if abs(a - before) / (limits[j].jerk * h) >= 1.0 - 1e-6 else LIMITED_BY_POSITION


@routine
def write_box_of_ramped_stop(state, limits, settings, n, box_rows):
    """Write the bounds of x for a stop of n ticks; return whether each joint has an x between them.

    Each limit bounds a': base + slope a' is between two numbers.
    """
    h, m, n_dof, good = settings.period, settings.ramp, box_rows.shape[0] // 2, True
    bend, kappa, way = 2.0 * m * h, deceleration(1.0, settings, n), rest_per_deceleration(settings, n)
    by_q, by_v, by_rest = changes_per_acceleration(settings)
    by_x = by_v + m * h
    for j in range(n_dof):
        a, change, most, speed = state[j].qdd, limits[j].jerk * h, limits[j].acceleration, limits[j].speed
        v = state[j].qd + 0.5 * h * a
        q = state[j].q + h * (state[j].qd + h * a / 3.0)
        low, high = max(a - change, -most), min(a + change, most)
        low, high = narrowed(low, high, v, by_v, -speed, speed)
        fastest = min(speed, most / kappa)
        low, high = narrowed(low, high, v, by_x, -fastest, fastest)
        least, greatest = limits[j].lower, limits[j].upper
        low, high = narrowed(low, high, q, by_q, least, greatest)
        low, high = narrowed(low, high, q + v * bend / 3.0, by_q + by_v * bend / 3.0, least, greatest)
        by = by_q + bend * (2.0 * by_v / 3.0 + bend / 6.0)
        low, high = narrowed(low, high, q + 2.0 * v * bend / 3.0, by, least, greatest)
        for to in (-bend * bend / 6.0, way):  # the end of the bend, and of the stop
            low, high = narrowed(low, high, q + v * (bend + kappa * to), by_rest + kappa * by_x * to, least, greatest)
        box_rows[j], box_rows[n_dof + j] = v + by_x * low, v + by_x * high
        good = good and low <= high
    return good


@kernel
def narrowed(low, high, base, slope, least, greatest):
    """Narrow the bounds of a so that base + slope a, slope > 0, is between two numbers too."""
    return max(low, (least - base) / slope), min(high, (greatest - base) / slope)


@kernel
def write_ramped_box(state, counters, limits, settings, box_rows):
    """Write the bounds of x, 2 n_dof rows; return the number of ticks of the stop.

    Return -1 if only the braking trajectory keeps the limits. First try one tick more than it has left, then as many, then one
    fewer.
    """
    left, least = counters.ticks - counters.done, 3 * int(settings.ramp)
    for n in (left + 1, left, left - 1):
        if (n >= least or n == left + 1) and write_box_of_ramped_stop(state, limits, settings, max(n, least), box_rows):
            return max(n, least)
    return -1
