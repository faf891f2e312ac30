"""Computes the full stop of all joints, and the velocities after which there is one within the limits.

The stop is synchronized: all joints rest after the same number of ticks n, each with a constant deceleration. So q moves on a
straight line, from q to q + qd n h / 2 with ticks of length h, and one certified edge decides on all of it. After k ticks

    q_k = q + x (2 - x) (end - q),    qd_k = (1 - x) qd,    x = k / n.

Acceleration is constant in a tick too. After a tick with velocity v at its end and a stop of n ticks, a joint rests at

    q + h (qd + v) / 2 + n h v / 2,

which is linear in v. So for each n the velocities v that keep the limits of position, speed and acceleration in the tick and in
the stop after it are a box. For the n that the certified stop has left after this tick, that stop's own velocity is in the box:
the box is never empty. In the tick the joint stays between its limits too: where it turns back, it does so no later than in the
certified stop, at the same or a greater deceleration.

With a limit of jerk ticks and stops are those of ``ramped_stop``, and v is what it calls x. The functions here that take the
settings compute one or the other, so that who calls them need not ask.
"""

from ulna.engine.decorators import kernel
from ulna.kernels.servo.ramped_stop import (
    BEYOND,
    ROUNDING,
    bend_moment,
    go_on_with_ramp,
    left_after_one_more,
    limit_of_ramp,
    ramped_stop_keeps,
    ramped_travel,
    ramped_way,
    rest_of_zero,
    write_ramped_box,
    write_ramped_stop,
    write_ramped_tick,
)
from ulna.kernels.servo.servo_records import LIMITED_BY_ACCELERATION, LIMITED_BY_POSITION, LIMITED_BY_VELOCITY

STILL = 1e-7  # of the velocity of one tick of acceleration: at rest


@kernel
def ticks_to_stop(state, limits, period):
    """Number of ticks that the stop from the velocity of a state takes."""
    most = 0.0
    for j in range(state.shape[0]):
        most = max(most, abs(state[j].qd) / (limits[j].acceleration * period))
    n = int(most)
    return n if most <= n + ROUNDING * most else n + 1


@kernel
def write_tick(x_rows, state, limits, settings, after):
    """Write the state after a tick that ends with these velocities, and the stop from there; how many ticks that takes.

    after: as the state is. A tick that nearly ends at rest, and can, does.
    """
    if settings.ramp > 0.0:
        return write_ramped_tick(x_rows, state, limits, settings, after)
    h, still = settings.period, True
    for j in range(x_rows.shape[0]):
        change = limits[j].acceleration * h
        still = still and abs(x_rows[j]) <= STILL * change and abs(state[j].qd) <= change
    for j in range(x_rows.shape[0]):
        after[j].qd = 0.0 if still else x_rows[j]
        after[j].q = state[j].q + 0.5 * h * (state[j].qd + after[j].qd)
        after[j].qdd = (after[j].qd - state[j].qd) / h
    return write_stop(after, limits, settings)


@kernel
def write_stop(state, limits, settings):
    """Write the stop that begins at a state; how many ticks it takes."""
    if settings.ramp > 0.0:
        return write_ramped_stop(state, limits, settings)
    ticks = ticks_to_stop(state, limits, settings.period)
    for j in range(state.shape[0]):
        state[j].start_qd, state[j].start_q = state[j].qd, state[j].q
        state[j].rest_q = state[j].q + 0.5 * ticks * settings.period * state[j].qd
    return ticks


@kernel
def stop_keeps(state, limits, settings, ticks):
    """Whether the stop of so many ticks that a state begins is within the limits that ``write_stop`` does not see to."""
    if settings.ramp > 0.0:
        return ramped_stop_keeps(state, limits, settings, ticks)
    good = True
    for j in range(state.shape[0]):
        good = good and limits[j].lower - BEYOND <= state[j].rest_q <= limits[j].upper + BEYOND
    return good


@kernel
def stop_velocity(state, counters, settings, j):
    """The velocity of entry j of q after one more tick of the certified stop."""
    if settings.ramp > 0.0:
        return left_after_one_more(state, counters, settings, j)
    n, done = counters.ticks, counters.done
    return 0.0 if n - done <= 1 else (1.0 - (done + 1) / n) * state[j].start_qd


@kernel
def go_on_stopping(state, counters, settings):
    """Write the state after one more tick of the certified stop."""
    n, n_dof = counters.ticks, state.shape[0]
    if counters.done >= n:
        for j in range(n_dof):
            state[j].qd, state[j].qdd = 0.0, 0.0
        return
    if settings.ramp > 0.0:
        go_on_with_ramp(state, counters, settings)
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
def way_to_rest(settings, ticks):
    """How far a velocity at the end of a tick moves a joint in the tick and in the stop after it [s]: the factor of v above."""
    return ramped_way(settings, ticks) if settings.ramp > 0.0 else 0.5 * settings.period * (1 + ticks)


@kernel
def beyond_rest_of_zero(state, settings, j):
    """How far beyond it the certified stop ends: beyond where entry j rests if the velocity after this tick is 0."""
    if settings.ramp > 0.0:
        return state[j].rest_q - rest_of_zero(state, settings, j)
    return state[j].rest_q - state[j].q - 0.5 * settings.period * state[j].qd


@kernel
def travel(state, after, settings, ticks, j):
    """A bound on how far entry j moves in all, forth and back added, in a tick and in the stop of so many ticks after it.

    Without a limit of jerk it is that from where the tick begins to where it ends, and from there to where the stop ends.
    """
    if settings.ramp > 0.0:
        return ramped_travel(state, after, settings, ticks, j)
    return abs(after[j].q - state[j].q) + abs(after[j].rest_q - after[j].q)


@kernel
def curve_moment(state, settings, ticks, before, t, j):
    """Position and acceleration of entry j at a time in the curve that leads to the line of a stop of so many ticks.

    state: Where the stop begins; t: from there on, below 0 in the tick before it; before: the acceleration where that begins.
    """
    if settings.ramp > 0.0:
        return bend_moment(state, settings, ticks, before, t, j)
    return state[j].start_q + t * (state[j].start_qd + 0.5 * t * state[j].qdd), state[j].qdd


@kernel
def limit_reached(x, state, limits, settings, ticks, j):
    """Which limit a velocity of entry j is at, that is at a border of the box for a stop of so many ticks: a status."""
    if settings.ramp > 0.0:
        return limit_of_ramp(x, state, limits, settings, ticks, j)
    if abs(x) >= limits[j].speed * (1.0 - 1e-9):
        return LIMITED_BY_VELOCITY
    change = abs(x - state[j].qd) / (limits[j].acceleration * settings.period)
    return LIMITED_BY_ACCELERATION if change >= 1.0 - 1e-6 else LIMITED_BY_POSITION


@kernel
def write_velocity_box(state, counters, limits, settings, box_rows):
    """Write the lower and the upper bounds of the velocities at the end of the tick, 2 n_dof rows; return the ticks of the stop.

    One tick more than the certified stop has left is tried first, then as many, and last one fewer. In the last box is the
    velocity of the certified stop. With a limit of jerk there may be no velocity but that one: then -1 is returned.
    """
    if settings.ramp > 0.0:
        return write_ramped_box(state, counters, limits, settings, box_rows)
    left = counters.ticks - counters.done
    for n in (left + 1, left):
        if is_box(state, counters, limits, settings, n, box_rows, widened=False):
            return n
    n = max(left - 1, 0)
    is_box(state, counters, limits, settings, n, box_rows, widened=True)
    return n


@kernel
def is_box(state, counters, limits, settings, n, box_rows, widened):
    """Write the bounds for a stop of n ticks; whether there is a velocity between them. Widened: to the certified stop's."""
    n_dof, good, tick = box_rows.shape[0] // 2, True, settings.period
    way = way_to_rest(settings, n)
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
