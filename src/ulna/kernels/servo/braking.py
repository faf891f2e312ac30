"""Computes the braking trajectory of all joints, and the velocities after which one exists within the limits.

All joints come to rest after the same number of ticks n, each with a constant deceleration. With ticks of length h, q moves on a
straight line from q to q + qd n h / 2. So one certified edge covers the whole trajectory. After k ticks

    q_k = q + x (2 - x) (end - q),    qd_k = (1 - x) qd,    x = k / n.

Acceleration is constant within a tick too. After a tick with velocity v at its end and a stop of n ticks, a joint rests at

    q + h (qd + v) / 2 + n h v / 2,

which is linear in v. So for each n the limits of position, speed and acceleration, in the tick and in the stop, are bounds of v:
a box. After this tick the current braking trajectory has some number of ticks left. For this n its own velocity is in the box, so
the box is never empty. In the tick the joint stays between its limits too. A joint that turns back within the tick decelerates at
least as much as along the current braking trajectory. So it turns back no later than there.

With a limit of jerk, ``ramped_stop`` computes the ticks and the stops. The unknown is then not the velocity v, but the velocity x
that remains after the acceleration has ramped down to 0. The functions here that take the settings compute one or the other, so
callers need not distinguish the two.
"""

from ulna.engine.decorators import kernel
from ulna.kernels.servo.ramped_stop import (
    POSITION_ROUNDING,
    ROUNDING,
    bend_state,
    continue_ramped_stop,
    ramped_limit_reached,
    ramped_stop_is_within_limits,
    ramped_travel,
    ramped_travel_per_velocity,
    rest_of_zero_velocity,
    velocity_left_after_tick,
    write_ramped_box,
    write_ramped_stop,
    write_ramped_tick,
)
from ulna.kernels.servo.servo_records import LIMITED_BY_ACCELERATION, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY

REST_TOLERANCE = 1e-7  # share of the velocity of one tick of acceleration; slower counts as rest


@kernel
def ticks_to_stop(state, limits, period):
    """Compute the number of ticks of the stop from the velocity of a state."""
    most = 0.0
    for j in range(state.shape[0]):
        most = max(most, abs(state[j].qd) / (limits[j].acceleration * period))
    n = int(most)
    return n if most <= n + ROUNDING * most else n + 1


@kernel
def write_tick(x_rows, state, limits, settings, after):
    """Write the state after a tick that ends with these velocities, and the stop from there; return its ticks.

    after: Has the shape of the state. If the tick ends nearly at rest, and can end at rest, it does.
    """
    if settings.ramp > 0.0:
        return write_ramped_tick(x_rows, state, limits, settings, after)
    h, still = settings.period, True
    for j in range(x_rows.shape[0]):
        change = limits[j].acceleration * h
        still = still and abs(x_rows[j]) <= REST_TOLERANCE * change and abs(state[j].qd) <= change
    for j in range(x_rows.shape[0]):
        after[j].qd = 0.0 if still else x_rows[j]
        after[j].q = state[j].q + 0.5 * h * (state[j].qd + after[j].qd)
        after[j].qdd = (after[j].qd - state[j].qd) / h
    return write_stop(after, limits, settings)


@kernel
def write_stop(state, limits, settings):
    """Write the stop that begins at a state; return its number of ticks."""
    if settings.ramp > 0.0:
        return write_ramped_stop(state, limits, settings)
    ticks = ticks_to_stop(state, limits, settings.period)
    for j in range(state.shape[0]):
        state[j].start_qd, state[j].start_q = state[j].qd, state[j].q
        state[j].rest_q = state[j].q + 0.5 * ticks * settings.period * state[j].qd
    return ticks


@kernel
def stop_is_within_limits(state, limits, settings, ticks):
    """Whether the stop of a state, of so many ticks, keeps the limits that ``write_stop`` does not ensure."""
    if settings.ramp > 0.0:
        return ramped_stop_is_within_limits(state, limits, settings, ticks)
    good = True
    for j in range(state.shape[0]):
        good = good and limits[j].lower - POSITION_ROUNDING <= state[j].rest_q <= limits[j].upper + POSITION_ROUNDING
    return good


@kernel
def stop_velocity(state, counters, settings, j):
    """Velocity of entry j of q after one more tick of the braking trajectory."""
    if settings.ramp > 0.0:
        return velocity_left_after_tick(state, counters, settings, j)
    n, done = counters.ticks, counters.done
    return 0.0 if n - done <= 1 else (1.0 - (done + 1) / n) * state[j].start_qd


@kernel
def continue_stop(state, counters, settings):
    """Write the state after one more tick of the braking trajectory."""
    n, n_dof = counters.ticks, state.shape[0]
    if counters.done >= n:
        for j in range(n_dof):
            state[j].qd, state[j].qdd = 0.0, 0.0
        return
    if settings.ramp > 0.0:
        continue_ramped_stop(state, counters, settings)
        counters.done += 1
        return
    x = (counters.done + 1) / n
    for j in range(n_dof):
        state[j].qd = stop_velocity(state, counters, settings, j)
        state[j].qdd = -state[j].start_qd / (n * settings.period)
        moved = state[j].start_q + x * (2.0 - x) * (state[j].rest_q - state[j].start_q)
        state[j].q = state[j].rest_q if counters.done + 1 == n else moved
    counters.done += 1


@kernel
def travel_per_velocity(settings, ticks):
    """Travel until rest per velocity at the end of the tick [s]: the factor of v in the formula above.

    It includes the tick and the stop of so many ticks after it.
    """
    return ramped_travel_per_velocity(settings, ticks) if settings.ramp > 0.0 else 0.5 * settings.period * (1 + ticks)


@kernel
def rest_offset(state, settings, j):
    """Distance [rad or m] to the end of the braking trajectory, from where entry j would rest with velocity 0.

    That is the velocity at the end of this tick.
    """
    if settings.ramp > 0.0:
        return state[j].rest_q - rest_of_zero_velocity(state, settings, j)
    return state[j].rest_q - state[j].q - 0.5 * settings.period * state[j].qd


@kernel
def travel(state, after, settings, ticks, j):
    """Upper bound of the travel of entry j in a tick and the stop after it, back and forth added.

    Without a limit of jerk it is the distance of the tick plus that of the stop.
    """
    if settings.ramp > 0.0:
        return ramped_travel(state, after, settings, ticks, j)
    return abs(after[j].q - state[j].q) + abs(after[j].rest_q - after[j].q)


@kernel
def curve_state(state, settings, ticks, before, t, j):
    """Position and acceleration of entry j at a time t of the curve before the straight line of a stop.

    state: The state where the stop begins. t: The time from there on, negative in the tick before it. before: The acceleration at
    the beginning of that tick.
    """
    if settings.ramp > 0.0:
        return bend_state(state, settings, ticks, before, t, j)
    return state[j].start_q + t * (state[j].start_qd + 0.5 * t * state[j].qdd), state[j].qdd


@kernel
def limit_reached(x, state, limits, settings, ticks, j):
    """Status of the limit that a velocity of entry j has reached, at the border of its box."""
    if settings.ramp > 0.0:
        return ramped_limit_reached(x, state, limits, settings, ticks, j)
    if abs(x) >= limits[j].speed * (1.0 - 1e-9):
        return LIMITED_BY_VELOCITY
    change = abs(x - state[j].qd) / (limits[j].acceleration * settings.period)
    return LIMITED_BY_ACCELERATION if change >= 1.0 - 1e-6 else LIMITED_BY_POSITION


@kernel
def write_velocity_box(state, counters, limits, settings, box_rows):
    """Write the lower and upper bounds of the velocities at the end of the tick, 2 n_dof rows.

    Return the number of ticks of the stop. First try one tick more than the braking trajectory has left, then as many, then one
    fewer. The last box contains the velocity of the braking trajectory. With a limit of jerk only that velocity may be possible:
    then -1 is returned.
    """
    if settings.ramp > 0.0:
        return write_ramped_box(state, counters, limits, settings, box_rows)
    left = counters.ticks - counters.done
    for n in (left + 1, left):
        if write_box_of_stop(state, counters, limits, settings, n, box_rows, widened=False):
            return n
    n = max(left - 1, 0)
    write_box_of_stop(state, counters, limits, settings, n, box_rows, widened=True)
    return n


@kernel
def write_box_of_stop(state, counters, limits, settings, n, box_rows, widened):
    """Write the bounds for a stop of n ticks; return whether any velocity satisfies them.

    widened: Whether the bounds are widened to include the velocity of the braking trajectory.
    """
    n_dof, good, tick = box_rows.shape[0] // 2, True, settings.period
    way = travel_per_velocity(settings, n)
    for j in range(n_dof):
        most = min(limits[j].speed, limits[j].acceleration * tick * n)
        change, half = limits[j].acceleration * tick, 0.5 * tick * state[j].qd
        low = max(state[j].qd - change, -most, (limits[j].lower - state[j].q - half) / way)
        high = min(state[j].qd + change, most, (limits[j].upper - state[j].q - half) / way)
        if widened:
            known = stop_velocity(state, counters, settings, j)
            low, high = min(low, known), max(high, known)
        box_rows[j], box_rows[n_dof + j] = low, high
        good = good and low <= high
    return good
