"""How a search goes: seeds and budgets, postures, and paths that must not jump."""

import numpy as np
import pytest

import robots
from ulna import Robot

HUNDREDTH = (0.0, 0.01, 0.0)


def shifted(T, xyz):
    """The pose at one displacement or at each of many."""
    xyz = np.asarray(xyz)
    T = np.broadcast_to(T, (*xyz.shape[:-1], 4, 4)).copy()
    T[..., :3, 3] += xyz
    return T


def random_targets(robot, n):
    return robot.forward_kinematics(np.random.default_rng(7).uniform(robot.lower, robot.upper, (n, robot.n_dof)))


# ---- seeds and budgets


def test_the_same_seed_gives_the_same_bits_and_another_seed_another_branch(panda):
    T = random_targets(panda, 100)
    first, again, other = (panda.inverse_kinematics(T, seed=seed) for seed in (0, 0, 1))
    assert np.array_equal(first.q, again.q)
    assert np.array_equal(first.iterations, again.iterations)
    assert other.success.all()
    assert np.abs(first.q - other.q).max() > 0.1


def test_numpys_own_random_state_is_neither_used_nor_moved(panda):
    T = random_targets(panda, 10)
    np.random.seed(1)  # noqa: NPY002
    state, first = np.random.get_state()[1].copy(), panda.inverse_kinematics(T, seed=11).q  # noqa: NPY002
    assert np.array_equal(np.random.get_state()[1], state)  # noqa: NPY002
    np.random.seed(2)  # noqa: NPY002
    assert np.array_equal(panda.inverse_kinematics(T, seed=11).q, first)


def test_a_row_has_the_same_bits_whatever_rows_are_beside_it(panda):
    T = shifted(panda.forward_kinematics(panda.home), np.random.default_rng(2).uniform(-0.1, 0.1, (20, 3)))
    options = {"q_seed": panda.home, "max_iterations": 50}
    whole = panda.inverse_kinematics(T, **options)
    for rows in (slice(0, 1), slice(3, 4), slice(5, 14), slice(19, 20), slice(None, None, -1)):
        part = panda.inverse_kinematics(T[rows], **options)
        assert np.array_equal(part.q, whole.q[rows])
        assert np.array_equal(part.position_error, whole.position_error[rows])


def test_one_seed_serves_all_targets_and_many_seeds_one_each(panda):
    T = random_targets(panda, 6).reshape(2, 3, 4, 4)
    one = panda.inverse_kinematics(T, q_seed=panda.home)
    each = panda.inverse_kinematics(T, q_seed=np.broadcast_to(panda.home, (2, 3, 7)))
    column = panda.inverse_kinematics(T, q_seed=np.broadcast_to(panda.home, (2, 1, 7)))
    assert np.array_equal(one.q, each.q)
    assert np.array_equal(one.q, column.q)
    own = np.random.default_rng(8).uniform(panda.lower, panda.upper, (2, 3, 7))
    already_there = panda.inverse_kinematics(panda.forward_kinematics(own), q_seed=own)
    assert (already_there.iterations == 0).all()
    np.testing.assert_allclose(already_there.q, own, rtol=0, atol=1e-12)


def test_a_seed_beyond_the_limits_starts_at_the_limits(panda):
    beyond = panda.inverse_kinematics(random_targets(panda, 1)[0], q_seed=panda.upper + 5.0, max_iterations=0)
    np.testing.assert_array_equal(beyond.q, panda.upper)


def test_without_a_step_the_seed_comes_back_with_its_errors(panda):
    T = panda.forward_kinematics(panda.home)
    short = panda.inverse_kinematics(shifted(T, HUNDREDTH), q_seed=panda.home, max_iterations=0)
    assert (bool(short.success), str(short.status), int(short.iterations)) == (False, "budget spent", 0)
    np.testing.assert_array_equal(short.q, panda.home)
    assert short.position_error == pytest.approx(0.01, abs=1e-15)
    there = panda.inverse_kinematics(T, q_seed=panda.home, max_iterations=0)
    assert (bool(there.success), str(there.status)) == (True, "solved")


@pytest.mark.parametrize("budget", [1, 2, 7, 60])
def test_a_budget_of_steps_is_used_up_by_the_seeds_own_start(panda, budget):
    T = shifted(panda.forward_kinematics(panda.home), (3.0, 0, 0))
    result = panda.inverse_kinematics(T, q_seed=panda.home, max_iterations=budget)
    assert (result.iterations, result.starts) == (budget, 1)


@pytest.mark.parametrize("budget", [0, 1, 19, 20, 21, 59, 60, 61, 79, 80, 200])
def test_the_steps_of_all_starts_together_are_within_the_budget(panda, monkeypatch, budget):
    """Told by what the search asks of its kernel: starts times steps."""
    from ulna.ik.search import restarts

    asked, run_starts = [], restarts.run_starts
    monkeypatch.setattr(
        restarts,
        "run_starts",
        lambda problem, order, part: asked.append(part.count * part.steps) or run_starts(problem, order, part),
    )
    T = shifted(panda.forward_kinematics(panda.home), HUNDREDTH)
    for options in ({}, {"q_seed": panda.home}, {"rank": "mid_range"}, {"posture": panda.home}):
        asked.clear()
        result = panda.inverse_kinematics(T, max_iterations=budget, held=panda.joint_names, **options)
        assert result.status == "budget spent"
        assert budget - 20 < sum(asked) <= budget, options


# ---- postures and paths


@pytest.mark.parametrize("away", [0.05, 0.3])
def test_a_posture_brings_home_back(panda, away):
    T = panda.forward_kinematics(panda.home)
    result = panda.inverse_kinematics(T, q_seed=panda.home + away, posture=panda.home)
    assert result.success
    np.testing.assert_allclose(result.q, panda.home, rtol=0, atol=1e-9)


def test_without_a_posture_the_arm_stays_where_the_null_space_left_it(panda):
    result = panda.inverse_kinematics(panda.forward_kinematics(panda.home), q_seed=panda.home + 0.05)
    assert result.success
    assert np.abs(result.q - panda.home).max() > 1e-3


def circle(panda, n, radius):
    angle = np.linspace(0, 2 * np.pi, n)
    offsets = radius * np.column_stack([np.cos(angle) - 1, np.sin(angle), np.zeros(n)])
    return shifted(panda.forward_kinematics(panda.home), offsets)


@pytest.mark.parametrize("posture", [False, True], ids=["free", "with a posture"])
def test_a_path_followed_from_sample_to_sample_never_jumps(panda, posture):
    """A circle of 10 cm in 300 samples of 2 mm: no joint may turn more than 0.02 rad from one to the next."""
    q, steps = panda.home, []
    for T in circle(panda, 300, 0.1):
        result = panda.inverse_kinematics(T, q_seed=q, posture=panda.home if posture else None)
        assert result.success
        steps.append(np.abs(result.q - q).max())
        q = result.q
    assert max(steps) < 0.02
    assert sum(steps) > 0.3, "the arm must have moved"
    if posture:
        np.testing.assert_allclose(q, panda.home, rtol=0, atol=1e-6)


def test_with_a_seed_the_branch_of_the_seed_wins_even_where_another_is_found_sooner():
    """Half a radian away in every joint a search from a random start often needs fewer steps; its answer is a jump."""
    arm = Robot.from_dh(robots.UR5, convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 6)
    rng = np.random.default_rng(3)
    seeds = np.array([0, -1.2, 1.3, -1, -1.5, 0]) + rng.uniform(-1, 1, (2000, 6)) * np.array([1, 0.4, 0.5, 0.8, 0.7, 2])
    expected = seeds + rng.uniform(-0.5, 0.5, seeds.shape)
    result = arm.inverse_kinematics(arm.forward_kinematics(expected), q_seed=seeds)
    assert result.success.all()
    assert np.abs(result.q - expected).max() < 1.0


def test_an_arm_with_one_solution_to_a_branch_retraces_the_path_of_its_joints():
    """Six joints, elbow and wrist kept bent: the only way to follow the targets without a jump is the path they came from."""
    arm = Robot.from_dh(robots.UR5, convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 6)
    phase = np.linspace(0, 2 * np.pi, 500)[:, None] * [1, 2, 1, 3, 1, 2] + np.arange(6)
    path = np.array([0, -1.2, 1.3, -1, -1.5, 0]) + np.array([1, 0.4, 0.5, 0.8, 0.7, 2]) * np.sin(phase)
    q = path[0] + 0.01
    for T, expected in zip(arm.forward_kinematics(path), path, strict=True):
        result = arm.inverse_kinematics(T, q_seed=q)
        assert result.success
        np.testing.assert_allclose(result.q, expected, rtol=0, atol=1e-6)
        q = result.q
