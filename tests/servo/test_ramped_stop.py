"""A tick and a full stop with a limit of jerk: any velocity of the box keeps all limits at all times until the arm rests."""

import numpy as np
import pytest

from matrix import matrix
from ulna.kernels.servo import servo_layout as layout
from ulna.kernels.servo.braking import go_on_stopping, stop_velocity, write_velocity_box
from ulna.kernels.servo.ramped_stop import (
    ramped_moment,
    ramped_stop_keeps,
    ramped_travel,
    ramped_way,
    rest_of_zero,
    write_ramped_stop,
    write_ramped_tick,
)

N, TICK = 4, 0.01
T = np.linspace(0, TICK, 17)[:, None]


def limited(rng, ramp):
    """Limits and settings in which the greatest acceleration begins in some ticks, and an arm at rest."""
    limits, settings = np.zeros((layout.N_LIMITS, N)), np.array([TICK, 0.0, 1e-4, 0.0, ramp, TICK * (1 + ramp)])
    limits[layout.LOWER], limits[layout.UPPER] = -rng.uniform(0.01, 1, N), rng.uniform(0.01, 1, N)
    limits[layout.SPEED], limits[layout.ACCELERATION] = rng.uniform(0.1, 3, N), rng.uniform(1, 20, N)
    limits[layout.JERK] = limits[layout.ACCELERATION] / (ramp * TICK) * rng.uniform(1, 2, N)
    state, counters = np.zeros((layout.N_STATE, N)), np.zeros(layout.N_COUNTERS, dtype=np.int64)
    state[layout.Q] = state[layout.FROM] = state[layout.TO] = rng.uniform(limits[layout.LOWER], limits[layout.UPPER])
    return limits, settings, state, counters


def accept(x, limits, settings, state, counters):
    after = np.zeros_like(state)
    counters[layout.TICKS], counters[layout.DONE] = write_ramped_tick(x, state, limits, settings, after), 0
    kept = ramped_stop_keeps(after, limits, settings, counters[layout.TICKS])
    state[:] = after
    return kept


def keeps(before, state, limits):
    """Whether a tick of constant jerk leads from one state to the next, within the limits at all of its times."""
    (q, v, a), (q_end, v_end, a_end) = before, state[:3]
    jerk = (a_end - a) / TICK
    fine = q + T * (v + T * (a / 2 + T * jerk / 6))
    speeds = v + T * (a + T * jerk / 2)
    np.testing.assert_allclose(fine[-1], q_end, rtol=0, atol=1e-13)
    np.testing.assert_allclose(speeds[-1], v_end, rtol=0, atol=1e-12)
    assert (np.abs(jerk) <= limits[layout.JERK] * (1 + 1e-8)).all()
    assert (np.abs([a, a_end]) <= limits[layout.ACCELERATION] * (1 + 1e-8)).all()
    assert (np.abs(speeds) <= limits[layout.SPEED] * (1 + 1e-8)).all()
    assert (fine >= limits[layout.LOWER] - 1e-12).all()
    assert (fine <= limits[layout.UPPER] + 1e-12).all()


def stop(limits, settings, state, counters):
    """Go on with the certified stop to its end."""
    state, counters, end = state.copy(), counters.copy(), state[layout.TO].copy()
    while counters[layout.DONE] < counters[layout.TICKS]:
        before = state[:3].copy()
        go_on_stopping(state, counters, settings)
        keeps(before, state, limits)
    np.testing.assert_array_equal(state[layout.Q], end)
    assert not state[[layout.QD, layout.QDD]].any()
    before = state.copy()
    go_on_stopping(state, counters, settings)
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
            before = state[:3].copy()
            ticks, none = ticks + 1, none + (n < 0)
            if n < 0 or rng.random() < 0.15:
                go_on_stopping(state, counters, settings)
            else:
                assert (box[:N] <= box[N:]).all()
                low, high = box[:N], box[N:]
                share = rng.choice([0.0, 1.0, rng.random()], N) if k % 20 < 10 else rng.choice([0.0, 1.0])
                assert accept(low + share * (high - low), limits, settings, state, counters)
                assert counters[layout.TICKS] <= n
            keeps(before, state, limits)
            stop(limits, settings, state, counters)
    assert none < 0.2 * ticks


@pytest.mark.parametrize("ramp", [1, 3])
def test_where_it_rests_is_linear_in_the_velocity_that_is_left(rng, ramp):
    for _ in range(50):
        limits, settings, state, counters = limited(rng, ramp)
        limits[layout.LOWER], limits[layout.UPPER] = -10, 10
        box = np.empty(2 * N)
        for _ in range(20):
            write_velocity_box(state, counters, limits, settings, box)
            accept(rng.uniform(box[:N], box[N:]), limits, settings, state, counters)
        x = rng.uniform(-1, 1, N) * limits[layout.SPEED]
        after = np.zeros_like(state)
        n = write_ramped_tick(x, state, limits, settings, after)
        zero = np.array([rest_of_zero(state, settings, j) for j in range(N)])
        np.testing.assert_allclose(zero + ramped_way(settings, n) * x, after[layout.TO], rtol=0, atol=1e-10)
        if counters[layout.DONE] + 1 < counters[layout.TICKS]:
            known = np.array([stop_velocity(state, counters, settings, j) for j in range(N)])
            write_ramped_tick(known, state, limits, settings, after)
            go_on_stopping(state, counters, settings)
            np.testing.assert_allclose(after[:3], state[:3], rtol=0, atol=1e-10)


@pytest.mark.parametrize("ramp", [1, 3])
def test_the_way_to_and_fro_is_bounded_and_known_where_nothing_turns_back(rng, ramp):
    known = 0
    for _ in range(20):
        limits, settings, state, counters = limited(rng, ramp)
        box, after = np.empty(2 * N), np.zeros_like(state)
        for _ in range(20):
            if write_velocity_box(state, counters, limits, settings, box) < 0:
                break
            x = rng.uniform(box[:N], box[N:])
            n = write_ramped_tick(x, state, limits, settings, after)
            for j in range(N):
                q, v, a, jerk = *state[:3, j], (after[layout.QDD, j] - state[layout.QDD, j]) / TICK
                places = list((q + T * (v + T * (a / 2 + T * jerk / 6))).ravel())
                if n > 0:
                    places += [ramped_moment(after, settings, n, k, j)[0] for k in np.linspace(0, n, 16 * n + 1)]
                steps, most = np.diff(places), ramped_travel(state, after, settings, n, j)
                assert np.abs(steps).sum() <= most + 1e-12
                if (steps >= 0).all() and (state[layout.QD, j] + a * TICK / 2 >= 0) and x[j] >= 0:
                    known += 1
                    np.testing.assert_allclose(steps.sum(), most, rtol=0, atol=1e-12)
            accept(x, limits, settings, state, counters)
    assert known > 50


def test_a_stop_from_rest_takes_no_tick_and_one_that_is_too_long_is_refused(rng):
    limits, settings, state, _ = limited(rng, 2)
    assert write_ramped_stop(state, limits, settings) == 0
    assert ramped_stop_keeps(state, limits, settings, 0)
    state[layout.QD, 0] = limits[layout.SPEED, 0]
    state[layout.Q, 0] = limits[layout.UPPER, 0] - 1e-4
    n = write_ramped_stop(state, limits, settings)
    assert n >= 6
    assert not ramped_stop_keeps(state, limits, settings, n)
