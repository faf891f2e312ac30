"""One target with a seed: all lanes search from the first step; the seed's own solution counts first, then the nearest."""

import numpy as np
import pytest

from ulna import Robot


@pytest.fixture(scope="module")
def arm():
    """Seven joints like the Panda's, with offsets that leave it without a closed form."""
    half, a = np.pi / 2, 0.0825
    rows = [
        (0.02, 0.333, -half, 0), (0.01, 0.03, half, 0), (a, 0.316, half, 0), (-a, 0.02, -half, 0),
        (0.015, 0.384, half, 0), (0.088, 0.01, half, 0), (0, 0.21, 0, 0),
    ]  # fmt: skip
    limits = [(-2.9, 2.9), (-1.8, 1.8), (-2.9, 2.9), (-3.0, 0.0), (-2.9, 2.9), (0.0, 3.7), (-2.9, 2.9)]
    robot = Robot.from_dh(rows, convention="standard", limits=limits)
    assert robot.closed_form is None
    return robot


@pytest.fixture(scope="module")
def seeded(arm):
    """Targets all over the range, and what is found from the middle of it: one call each, and as a batch."""
    middle = (arm.lower + arm.upper) / 2
    T = arm.forward_kinematics(np.random.default_rng(5).uniform(arm.lower, arm.upper, (200, 7)))
    return middle, T, [arm.inverse_kinematics(pose, middle) for pose in T], arm.inverse_kinematics(T, middle)


def test_every_solution_reaches_its_target_within_the_limits(arm, seeded):
    _, T, alone, _ = seeded
    q = np.array([found.q for found in alone])
    assert all(found.success for found in alone)
    assert np.abs(arm.forward_kinematics(q) - T).max() < 3e-5
    assert ((q >= arm.lower) & (q <= arm.upper)).all()


def test_where_the_seeds_own_search_succeeds_its_solution_is_taken_bit_by_bit(seeded):
    _, _, alone, batch = seeded
    own = np.flatnonzero(batch.starts == 1)
    assert 100 < len(own) < 200
    for i in own:
        assert alone[i].starts == 1
        assert np.array_equal(alone[i].q, batch.q[i])


def test_where_it_fails_the_solution_is_nearer_than_that_of_a_few_random_starts(seeded):
    middle, _, alone, batch = seeded
    others = np.flatnonzero(batch.starts > 1)
    assert len(others) > 10
    assert all(alone[i].starts > 1 for i in others)
    away = np.array([np.abs(alone[i].q - middle).max() for i in others])
    before = np.abs(batch.q[others] - middle).max(axis=1)
    assert away.mean() < before.mean()
    assert np.mean(away <= before + 1e-6) > 0.9


def test_a_trace_of_another_start_ends_at_the_result(arm, seeded):
    middle, T, alone, _ = seeded
    i = next(i for i, found in enumerate(alone) if found.starts > 1)
    traced = arm.inverse_kinematics(T[i], middle, trace=True)
    assert np.array_equal(traced.q, alone[i].q)
    assert len(traced.trace) == traced.iterations + 1
    assert traced.trace[-1, 0] == pytest.approx(traced.position_error, abs=1e-12)


def test_another_random_seed_changes_only_what_the_seed_does_not_reach(arm, seeded):
    middle, T, alone, _ = seeded
    for pose, found in zip(T[:60], alone[:60], strict=True):
        other = arm.inverse_kinematics(pose, middle, seed=3)
        assert (other.starts == 1) == (found.starts == 1)
        assert found.starts > 1 or np.array_equal(other.q, found.q)
