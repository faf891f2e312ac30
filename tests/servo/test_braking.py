"""The full stop of a servo: any velocity of its box keeps all limits in the tick and in the stop after it."""

import numpy as np
import pytest

from ulna.kernels.servo import servo_layout as layout
from ulna.kernels.servo.braking import (
    go_on_stopping,
    stop_keeps,
    stop_velocity,
    write_stop,
    write_tick,
    write_velocity_box,
)

N, TICK = 4, 0.01


def moving(rng):
    """Limits, and a state in which a stop within them is under way."""
    limits, settings = np.zeros((layout.N_LIMITS, N)), np.array([TICK, 0.0, 1e-4, 0.0, 0.0, TICK])
    limits[layout.LOWER], limits[layout.UPPER] = -rng.uniform(0.01, 1, N), rng.uniform(0.01, 1, N)
    limits[layout.SPEED], limits[layout.ACCELERATION] = rng.uniform(0.5, 3, N), rng.uniform(1, 20, N)
    state, counters = np.zeros((layout.N_STATE, N)), np.zeros(layout.N_COUNTERS, dtype=np.int64)
    while True:
        rate = rng.uniform(-1, 1, N) * limits[layout.SPEED] * rng.choice([0.0, 0.1, 1.0])
        state[layout.Q], state[layout.QD] = rng.uniform(limits[layout.LOWER], limits[layout.UPPER]), rate
        ticks = counters[layout.TICKS] = write_stop(state, limits, settings)
        counters[layout.DONE] = 0
        if (state[layout.TO] >= limits[layout.LOWER]).all() and (state[layout.TO] <= limits[layout.UPPER]).all():
            for _ in range(rng.integers(ticks + 1)):
                go_on_stopping(state, counters, settings)
            return limits, settings, state, counters


@pytest.mark.slow
def test_any_velocity_of_the_box_keeps_the_limits_until_the_arm_rests(rng):
    t = np.linspace(0, TICK, 33)[:, None]
    for _ in range(500):
        limits, settings, state, counters = moving(rng)
        box = np.empty(2 * N)
        n = write_velocity_box(state, counters, limits, settings, box)
        stop = np.array([stop_velocity(state, counters, settings, j) for j in range(N)])
        for x in (box[:N], box[N:], rng.uniform(box[:N], box[N:]), np.clip(stop, box[:N], box[N:])):
            q, qd = state[layout.Q], state[layout.QD]
            after = np.zeros_like(state)
            ticks = write_tick(x, state, limits, settings, after)
            assert ticks <= n
            assert stop_keeps(after, limits, settings, ticks)
            np.testing.assert_allclose(after[:3], [q + (qd + x) * TICK / 2, x, (x - qd) / TICK], rtol=0, atol=1e-12)
            np.testing.assert_allclose(after[layout.TO], after[layout.Q] + ticks * TICK * x / 2, rtol=0, atol=1e-12)
            a = (x - qd) / TICK
            assert (np.abs(a) <= limits[layout.ACCELERATION] * (1 + 1e-9)).all()
            assert (np.abs(x) <= limits[layout.SPEED] + 1e-12).all()
            assert (np.abs(x) <= limits[layout.ACCELERATION] * TICK * ticks * (1 + 1e-8)).all()
            way = q + qd * t + 0.5 * a * t * t
            assert (way >= limits[layout.LOWER] - 1e-12).all()
            assert (way <= limits[layout.UPPER] + 1e-12).all()


def test_the_box_always_has_the_velocity_of_the_stop_or_of_a_longer_one(rng):
    for _ in range(500):
        limits, settings, state, counters = moving(rng)
        box = np.empty(2 * N)
        n, left = write_velocity_box(state, counters, limits, settings, box), counters[layout.TICKS] - counters[layout.DONE]
        assert (box[:N] <= box[N:]).all()
        if n == left - 1:
            stop = np.array([stop_velocity(state, counters, settings, j) for j in range(N)])
            assert (box[:N] <= stop).all()
            assert (stop <= box[N:]).all()


def test_a_stop_is_a_straight_line_of_constant_deceleration(rng):
    for _ in range(50):
        _, settings, state, counters = moving(rng)
        start, end, rate, n = (
            state[layout.FROM].copy(),
            state[layout.TO].copy(),
            state[layout.RATE].copy(),
            counters[layout.TICKS],
        )
        while counters[layout.DONE] < n:
            go_on_stopping(state, counters, settings)
            t = counters[layout.DONE] * TICK
            np.testing.assert_allclose(state[layout.Q], start + rate * t - rate / (n * TICK) * t * t / 2, atol=1e-12)
            np.testing.assert_allclose(state[layout.QD], rate - rate / (n * TICK) * t, atol=1e-12)
        go_on_stopping(state, counters, settings)
        if n > 0:
            np.testing.assert_array_equal(state[layout.Q], end)
        assert not state[layout.QD].any()
