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

With a limit of jerk ticks and stops are those of ``ramped_stop``, and v is what it calls x.
"""

from ulna.engine.decorators import kernel
from ulna.kernels.servo.ramped_stop import go_on_with_ramp, left_after_one_more, write_ramped_box
from ulna.kernels.servo.servo_layout import (
    ACCELERATION,
    DONE,
    FROM,
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

_ROUNDING = 1e-9  # of a number of ticks: a stop takes one tick more above it
_BEYOND = 1e-12  # [rad or m]: what rounding may put the end of a stop beyond a limit


@kernel
def ticks_to_stop(rate_rows, limits, tick):
    """How many ticks the stop from a velocity takes. ``rate_rows``: [rad/s or m/s], one for each entry of q."""
    most = 0.0
    for j in range(rate_rows.shape[0]):
        most = max(most, abs(rate_rows[j]) / (limits[ACCELERATION, j] * tick))
    n = int(most)
    return n if most <= n + _ROUNDING * most else n + 1


@kernel
def write_stop(state, counters, settings, rate_rows, ticks):
    """Write the stop that begins at the position of the state with a velocity and takes a number of ticks."""
    way = 0.5 * ticks * settings[TICK]
    for j in range(rate_rows.shape[0]):
        state[RATE, j], state[FROM, j] = rate_rows[j], state[Q, j]
        state[TO, j] = state[Q, j] + way * rate_rows[j]
    counters[TICKS], counters[DONE] = ticks, 0


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
def way_to_rest(tick, ticks):
    """How far a velocity at the end of a tick moves a joint in the tick and in the stop after it [s]: the factor of v above."""
    return 0.5 * tick * (1 + ticks)


@kernel
def write_way(rate_rows, state, limits, tick, ticks, points):
    """Write where a tick begins, where it ends with these velocities, and where the stop after it ends, shape (3 or more, n_dof).

    Whether the stop ends within the limits of position.
    """
    good = True
    for j in range(rate_rows.shape[0]):
        points[0, j] = state[Q, j]
        points[1, j] = points[0, j] + 0.5 * tick * (state[QD, j] + rate_rows[j])
        points[2, j] = points[1, j] + 0.5 * ticks * tick * rate_rows[j]
        good = good and limits[LOWER, j] - _BEYOND <= points[2, j] <= limits[UPPER, j] + _BEYOND
    return good


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
    way = way_to_rest(tick, n)
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
