"""The full stop of a servo: any velocity of its box keeps all limits in the tick and in the stop after it."""

import numpy as np
import pytest

from ulna.kernels.servo.braking import (
    continue_stop,
    stop_is_within_limits,
    stop_velocity,
    write_stop,
    write_tick,
    write_velocity_box,
)
from ulna.kernels.servo.servo_records import JointLimits, JointState, ServoSettings, StopCounters

N, TICK = 4, 0.01


def moving(rng):
    """Limits, and a state in which a stop within them is under way."""
    limits, settings = JointLimits.records(N), ServoSettings.records()[0]
    settings.period = settings.lag = TICK
    limits["lower"], limits["upper"] = -rng.uniform(0.01, 1, N), rng.uniform(0.01, 1, N)
    limits["speed"], limits["acceleration"] = rng.uniform(0.5, 3, N), rng.uniform(1, 20, N)
    state, counters = JointState.records(N), StopCounters.records()[0]
    while True:
        rate = rng.uniform(-1, 1, N) * limits["speed"] * rng.choice([0.0, 0.1, 1.0])
        state["q"], state["qd"] = rng.uniform(limits["lower"], limits["upper"]), rate
        ticks = counters.ticks = write_stop(state, limits, settings)
        counters.done = 0
        if (state["rest_q"] >= limits["lower"]).all() and (state["rest_q"] <= limits["upper"]).all():
            for _ in range(rng.integers(ticks + 1)):
                continue_stop(state, counters, settings)
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
            q, qd, after = state["q"], state["qd"], JointState.records(N)
            ticks = write_tick(x, state, limits, settings, after)
            assert ticks <= n
            assert stop_is_within_limits(after, limits, settings, ticks)
            np.testing.assert_allclose(
                [after["q"], after["qd"], after["qdd"]], [q + (qd + x) * TICK / 2, x, (x - qd) / TICK], rtol=0, atol=1e-12
            )
            np.testing.assert_allclose(after["rest_q"], after["q"] + ticks * TICK * x / 2, rtol=0, atol=1e-12)
            a = (x - qd) / TICK
            assert (np.abs(a) <= limits["acceleration"] * (1 + 1e-9)).all()
            assert (np.abs(x) <= limits["speed"] + 1e-12).all()
            assert (np.abs(x) <= limits["acceleration"] * TICK * ticks * (1 + 1e-8)).all()
            way = q + qd * t + 0.5 * a * t * t
            assert (way >= limits["lower"] - 1e-12).all()
            assert (way <= limits["upper"] + 1e-12).all()


def test_the_box_always_has_the_velocity_of_the_stop_or_of_a_longer_one(rng):
    for _ in range(500):
        limits, settings, state, counters = moving(rng)
        box = np.empty(2 * N)
        n, left = write_velocity_box(state, counters, limits, settings, box), counters.ticks - counters.done
        assert (box[:N] <= box[N:]).all()
        if n == left - 1:
            stop = np.array([stop_velocity(state, counters, settings, j) for j in range(N)])
            assert (box[:N] <= stop).all()
            assert (stop <= box[N:]).all()


def test_a_stop_is_a_straight_line_of_constant_deceleration(rng):
    for _ in range(50):
        _, settings, state, counters = moving(rng)
        start, end, rate, n = (
            state["start_q"].copy(),
            state["rest_q"].copy(),
            state["start_qd"].copy(),
            counters.ticks,
        )
        while counters.done < n:
            continue_stop(state, counters, settings)
            t = counters.done * TICK
            np.testing.assert_allclose(state["q"], start + rate * t - rate / (n * TICK) * t * t / 2, atol=1e-12)
            np.testing.assert_allclose(state["qd"], rate - rate / (n * TICK) * t, atol=1e-12)
        continue_stop(state, counters, settings)
        if n > 0:
            np.testing.assert_array_equal(state["q"], end)
        assert not state["qd"].any()
