"""A tick and a full stop with a limit of jerk: any velocity of the box keeps all limits at all times until the arm rests."""

import numpy as np
import pytest

from matrix import matrix
from ulna.kernels.servo.braking import continue_stop, stop_velocity, write_velocity_box
from ulna.kernels.servo.ramped_stop import (
    ramped_state,
    ramped_stop_is_within_limits,
    ramped_travel,
    ramped_travel_per_velocity,
    rest_of_zero_velocity,
    write_ramped_stop,
    write_ramped_tick,
)
from ulna.kernels.servo.servo_records import JointLimits, JointState, ServoSettings, StopCounters

N, TICK = 4, 0.01
T = np.linspace(0, TICK, 17)[:, None]


def now(state):
    """A copy of position, velocity and acceleration."""
    return np.array([state["q"], state["qd"], state["qdd"]])


def limited(rng, ramp):
    """Limits and settings in which the greatest acceleration begins in some ticks, and an arm at rest."""
    limits, settings = JointLimits.records(N), ServoSettings.records()[0]
    settings.period, settings.ramp, settings.lag = TICK, ramp, TICK * (1 + ramp)
    limits["lower"], limits["upper"] = -rng.uniform(0.01, 1, N), rng.uniform(0.01, 1, N)
    limits["speed"], limits["acceleration"] = rng.uniform(0.1, 3, N), rng.uniform(1, 20, N)
    limits["jerk"] = limits["acceleration"] / (ramp * TICK) * rng.uniform(1, 2, N)
    state, counters = JointState.records(N), StopCounters.records()
    state["q"] = state["start_q"] = state["rest_q"] = rng.uniform(limits["lower"], limits["upper"])
    return limits, settings, state, counters[0]


def accept(x, limits, settings, state, counters):
    after = JointState.records(N)
    counters.ticks, counters.done = write_ramped_tick(x, state, limits, settings, after), 0
    kept = ramped_stop_is_within_limits(after, limits, settings, counters.ticks)
    state[:] = after
    return kept


def keeps(before, state, limits):
    """Whether a tick of constant jerk leads from one state to the next, within the limits at all of its times."""
    (q, v, a), (q_end, v_end, a_end) = before, now(state)
    jerk = (a_end - a) / TICK
    fine = q + T * (v + T * (a / 2 + T * jerk / 6))
    speeds = v + T * (a + T * jerk / 2)
    np.testing.assert_allclose(fine[-1], q_end, rtol=0, atol=1e-13)
    np.testing.assert_allclose(speeds[-1], v_end, rtol=0, atol=1e-12)
    assert (np.abs(jerk) <= limits["jerk"] * (1 + 1e-8)).all()
    assert (np.abs([a, a_end]) <= limits["acceleration"] * (1 + 1e-8)).all()
    assert (np.abs(speeds) <= limits["speed"] * (1 + 1e-8)).all()
    assert (fine >= limits["lower"] - 1e-12).all()
    assert (fine <= limits["upper"] + 1e-12).all()


def stop(limits, settings, state, counters):
    """Go on with the certified stop to its end."""
    state, counters, end = state.copy(), counters.copy(), state["rest_q"].copy()
    while counters.done < counters.ticks:
        before = now(state)
        continue_stop(state, counters, settings)
        keeps(before, state, limits)
    np.testing.assert_array_equal(state["q"], end)
    assert not np.any([state["qd"], state["qdd"]])
    before = state.copy()
    continue_stop(state, counters, settings)
    np.testing.assert_array_equal(state, before)


@pytest.mark.slow
@pytest.mark.parametrize("ramp", matrix([1, 2, 7], [2]))
def test_any_velocity_of_the_box_keeps_the_limits_until_the_arm_rests(rng, ramp):
    """In motions of corners of the box, of its inside and of parts of stops, so that all kinds of states are met."""
    none = ticks = 0
    for _ in range(40):
        limits, settings, state, counters = limited(rng, ramp)
        box = np.empty(2 * N)
        for k in range(60):
            n = write_velocity_box(state, counters, limits, settings, box)
            before = now(state)
            ticks, none = ticks + 1, none + (n < 0)
            if n < 0 or rng.random() < 0.15:
                continue_stop(state, counters, settings)
            else:
                assert (box[:N] <= box[N:]).all()
                low, high = box[:N], box[N:]
                share = rng.choice([0.0, 1.0, rng.random()], N) if k % 20 < 10 else rng.choice([0.0, 1.0])
                assert accept(low + share * (high - low), limits, settings, state, counters)
                assert counters.ticks <= n
            keeps(before, state, limits)
            stop(limits, settings, state, counters)
    assert none < 0.2 * ticks


@pytest.mark.parametrize("ramp", [1, 3])
def test_where_it_rests_is_linear_in_the_velocity_that_is_left(rng, ramp):
    for _ in range(50):
        limits, settings, state, counters = limited(rng, ramp)
        limits["lower"], limits["upper"] = -10, 10
        box = np.empty(2 * N)
        for _ in range(20):
            write_velocity_box(state, counters, limits, settings, box)
            accept(rng.uniform(box[:N], box[N:]), limits, settings, state, counters)
        x = rng.uniform(-1, 1, N) * limits["speed"]
        after = JointState.records(N)
        n = write_ramped_tick(x, state, limits, settings, after)
        zero = np.array([rest_of_zero_velocity(state, settings, j) for j in range(N)])
        np.testing.assert_allclose(zero + ramped_travel_per_velocity(settings, n) * x, after["rest_q"], rtol=0, atol=1e-10)
        if counters.done + 1 < counters.ticks:
            known = np.array([stop_velocity(state, counters, settings, j) for j in range(N)])
            write_ramped_tick(known, state, limits, settings, after)
            continue_stop(state, counters, settings)
            np.testing.assert_allclose(now(after), now(state), rtol=0, atol=1e-10)


@pytest.mark.parametrize("ramp", [1, 3])
def test_the_way_to_and_fro_is_bounded_and_known_where_nothing_turns_back(rng, ramp):
    known = 0
    for _ in range(20):
        limits, settings, state, counters = limited(rng, ramp)
        box, after = np.empty(2 * N), JointState.records(N)
        for _ in range(20):
            if write_velocity_box(state, counters, limits, settings, box) < 0:
                break
            x = rng.uniform(box[:N], box[N:])
            n = write_ramped_tick(x, state, limits, settings, after)
            for j in range(N):
                q, v, a, jerk = *now(state)[:, j], (after[j].qdd - state[j].qdd) / TICK
                places = list((q + T * (v + T * (a / 2 + T * jerk / 6))).ravel())
                if n > 0:
                    places += [ramped_state(after, settings, n, k, j)[0] for k in np.linspace(0, n, 16 * n + 1)]
                steps, most = np.diff(places), ramped_travel(state, after, settings, n, j)
                assert np.abs(steps).sum() <= most + 1e-12
                if (steps >= 0).all() and (state[j].qd + a * TICK / 2 >= 0) and x[j] >= 0:
                    known += 1
                    np.testing.assert_allclose(steps.sum(), most, rtol=0, atol=1e-12)
            accept(x, limits, settings, state, counters)
    assert known > 50


def test_a_stop_from_rest_takes_no_tick_and_one_that_is_too_long_is_refused(rng):
    limits, settings, state, _ = limited(rng, 2)
    assert write_ramped_stop(state, limits, settings) == 0
    assert ramped_stop_is_within_limits(state, limits, settings, 0)
    state[0].qd = limits[0].speed
    state[0].q = limits[0].upper - 1e-4
    n = write_ramped_stop(state, limits, settings)
    assert n >= 6
    assert not ramped_stop_is_within_limits(state, limits, settings, n)
