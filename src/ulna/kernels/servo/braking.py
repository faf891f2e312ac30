"""Computes the full stop of all joints, and the velocities after which there is one within the limits.

The stop is synchronised: all joints rest after the same number of ticks n, each with a constant deceleration. So q moves on a
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
from ulna.kernels.servo.servo_layout import (
    ACCELERATION,
    DONE,
    FROM,
    LIMITED_BY_ACCELERATION,
    LIMITED_BY_POSITION,
    LIMITED_BY_VELOCITY,
    LOWER,
    QD,
    QDD,
    RAMP,
    RATE,
    SPEED,
    TICK,
    TICKS,
    TO,
    UPPER,
    Q,
)

STILL = 1e-7  # of the velocity of one tick of acceleration: at rest


@kernel
def ticks_to_stop(rate_rows, limits, tick):
    """How many ticks the stop from a velocity takes. ``rate_rows``: [rad/s or m/s], one for each entry of q."""
    most = 0.0
    for j in range(rate_rows.shape[0]):
        most = max(most, abs(rate_rows[j]) / (limits[ACCELERATION, j] * tick))
    n = int(most)
    return n if most <= n + ROUNDING * most else n + 1


@kernel
def write_tick(x_rows, state, limits, settings, after):
    """Write the state after a tick that ends with these velocities, and the stop from there; how many ticks that takes.

    after: (N_STATE, n_dof), as the state is. A tick that nearly ends at rest, and can, does.
    """
    if settings[RAMP] > 0.0:
        return write_ramped_tick(x_rows, state, limits, settings, after)
    h, still = settings[TICK], True
    for j in range(x_rows.shape[0]):
        change = limits[ACCELERATION, j] * h
        still = still and abs(x_rows[j]) <= STILL * change and abs(state[QD, j]) <= change
    for j in range(x_rows.shape[0]):
        after[QD, j] = 0.0 if still else x_rows[j]
        after[Q, j] = state[Q, j] + 0.5 * h * (state[QD, j] + after[QD, j])
        after[QDD, j] = (after[QD, j] - state[QD, j]) / h
    return write_stop(after, limits, settings)


@kernel
def write_stop(state, limits, settings):
    """Write the stop that begins at a state; how many ticks it takes."""
    if settings[RAMP] > 0.0:
        return write_ramped_stop(state, limits, settings)
    ticks = ticks_to_stop(state[QD], limits, settings[TICK])
    for j in range(state.shape[1]):
        state[RATE, j], state[FROM, j] = state[QD, j], state[Q, j]
        state[TO, j] = state[Q, j] + 0.5 * ticks * settings[TICK] * state[QD, j]
    return ticks


@kernel
def stop_keeps(state, limits, settings, ticks):
    """Whether the stop of so many ticks that a state begins is within the limits that ``write_stop`` does not see to."""
    if settings[RAMP] > 0.0:
        return ramped_stop_keeps(state, limits, settings, ticks)
    good = True
    for j in range(state.shape[1]):
        good = good and limits[LOWER, j] - BEYOND <= state[TO, j] <= limits[UPPER, j] + BEYOND
    return good


@kernel
def stop_velocity(state, counters, settings, j):
    """The velocity of entry j of q after one more tick of the certified stop."""
    if settings[RAMP] > 0.0:
        return left_after_one_more(state, counters, settings, j)
    n, done = counters[TICKS], counters[DONE]
    return 0.0 if n - done <= 1 else (1.0 - (done + 1) / n) * state[RATE, j]


@kernel
def go_on_stopping(state, counters, settings):
    """Write the state after one more tick of the certified stop."""
    n, n_dof = counters[TICKS], state.shape[1]
    if counters[DONE] >= n:
        for j in range(n_dof):
            state[QD, j], state[QDD, j] = 0.0, 0.0
        return
    if settings[RAMP] > 0.0:
        go_on_with_ramp(state, counters, settings)
        counters[DONE] += 1
        return
    x = (counters[DONE] + 1) / n
    for j in range(n_dof):
        state[QD, j] = stop_velocity(state, counters, settings, j)
        state[QDD, j] = -state[RATE, j] / (n * settings[TICK])
        moved = state[FROM, j] + x * (2.0 - x) * (state[TO, j] - state[FROM, j])
        state[Q, j] = state[TO, j] if counters[DONE] + 1 == n else moved
    counters[DONE] += 1


@kernel
def way_to_rest(settings, ticks):
    """How far a velocity at the end of a tick moves a joint in the tick and in the stop after it [s]: the factor of v above."""
    return ramped_way(settings, ticks) if settings[RAMP] > 0.0 else 0.5 * settings[TICK] * (1 + ticks)


@kernel
def beyond_rest_of_zero(state, settings, j):
    """How far beyond it the certified stop ends: beyond where entry j rests if the velocity after this tick is 0."""
    if settings[RAMP] > 0.0:
        return state[TO, j] - rest_of_zero(state, settings, j)
    return state[TO, j] - state[Q, j] - 0.5 * settings[TICK] * state[QD, j]


@kernel
def travel(state, after, settings, ticks, j):
    """A bound on how far entry j moves in all, forth and back added, in a tick and in the stop of so many ticks after it.

    Without a limit of jerk it is that from where the tick begins to where it ends, and from there to where the stop ends.
    """
    if settings[RAMP] > 0.0:
        return ramped_travel(state, after, settings, ticks, j)
    return abs(after[Q, j] - state[Q, j]) + abs(after[TO, j] - after[Q, j])


@kernel
def curve_moment(state, settings, ticks, before, t, j):
    """Position and acceleration of entry j at a time in the curve that leads to the line of a stop of so many ticks.

    state: Where the stop begins; t: from there on, below 0 in the tick before it; before: the acceleration where that begins.
    """
    if settings[RAMP] > 0.0:
        return bend_moment(state, settings, ticks, before, t, j)
    return state[FROM, j] + t * (state[RATE, j] + 0.5 * t * state[QDD, j]), state[QDD, j]


@kernel
def limit_reached(x, state, limits, settings, ticks, j):
    """Which limit a velocity of entry j is at, that is at a border of the box for a stop of so many ticks: a status."""
    if settings[RAMP] > 0.0:
        return limit_of_ramp(x, state, limits, settings, ticks, j)
    if abs(x) >= limits[SPEED, j] * (1.0 - 1e-9):
        return LIMITED_BY_VELOCITY
    change = abs(x - state[QD, j]) / (limits[ACCELERATION, j] * settings[TICK])
    return LIMITED_BY_ACCELERATION if change >= 1.0 - 1e-6 else LIMITED_BY_POSITION


@kernel
def write_velocity_box(state, counters, limits, settings, box_rows):
    """Write the lower and the upper bounds of the velocities at the end of the tick, 2 n_dof rows; return the ticks of the stop.

    One tick more than the certified stop has left is tried first, then as many, and last one fewer. In the last box is the
    velocity of the certified stop. With a limit of jerk there may be no velocity but that one: then -1 is returned.
    """
    if settings[RAMP] > 0.0:
        return write_ramped_box(state, counters, limits, settings, box_rows)
    left = counters[TICKS] - counters[DONE]
    for n in (left + 1, left):
        if is_box(state, counters, limits, settings, n, box_rows, widened=False):
            return n
    n = max(left - 1, 0)
    is_box(state, counters, limits, settings, n, box_rows, widened=True)
    return n


@kernel
def is_box(state, counters, limits, settings, n, box_rows, widened):
    """Write the bounds for a stop of n ticks; whether there is a velocity between them. Widened: to the certified stop's."""
    n_dof, good, tick = box_rows.shape[0] // 2, True, settings[TICK]
    way = way_to_rest(settings, n)
    for j in range(n_dof):
        most = min(limits[SPEED, j], limits[ACCELERATION, j] * tick * n)
        change, half = limits[ACCELERATION, j] * tick, 0.5 * tick * state[QD, j]
        low = max(state[QD, j] - change, -most, (limits[LOWER, j] - state[Q, j] - half) / way)
        high = min(state[QD, j] + change, most, (limits[UPPER, j] - state[Q, j] - half) / way)
        if widened:
            known = stop_velocity(state, counters, settings, j)
            low, high = min(low, known), max(high, known)
        box_rows[j], box_rows[n_dof + j] = low, high
        good = good and low <= high
    return good
