"""What a task asks is met, judged by forward kinematics and Rodrigues' formula, and what it frees is told and not counted."""

import numpy as np
import pytest

import formulas
import ulna
from ulna import InputError, Robot, Task

TOLERANCE = 1e-5
N = 300
FREE = float("inf")


@pytest.fixture(scope="module")
def poses(panda):
    q = np.random.default_rng(21).uniform(panda.lower, panda.upper, (N, 7))
    return panda.forward_kinematics(q)


def distances(panda, result, T):
    return np.linalg.norm(panda.forward_kinematics(result.q)[:, :3, 3] - T[:, :3, 3], axis=1)


def assert_solved_within_limits(robot, result):
    assert result.success.all(), str(result)
    assert (result.status == "solved").all()
    assert ((result.q >= robot.lower) & (result.q <= robot.upper)).all()


def turned(T, rng):
    """The same positions with orientations of no relation."""
    T = T.copy()
    T[:, :3, :3] = [formulas.rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi)) for _ in T]
    return T


def test_a_position_is_met_in_whatever_orientation(panda, poses, rng):
    T = turned(poses, rng)
    result = panda.inverse_kinematics(T, task="position")
    assert_solved_within_limits(panda, result)
    assert distances(panda, result, T).max() <= TOLERANCE + 1e-12
    assert result.rotation_error.max() > 1.0


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0.6, 0, -0.8), (1, 1, 1), (0, 0, -3)], ids=str)
def test_an_axis_is_brought_onto_the_targets_and_the_turn_about_it_is_free(panda, poses, rng, axis):
    unit = np.array(axis) / np.linalg.norm(axis)
    T = poses.copy()
    T[:, :3, :3] = [R @ formulas.rotation(axis, rng.uniform(-np.pi, np.pi)) for R in T[:, :3, :3]]
    result = panda.inverse_kinematics(T, task=Task.pointing(axis))
    assert_solved_within_limits(panda, result)
    reached = panda.forward_kinematics(result.q)
    assert np.linalg.norm(reached[:, :3, 3] - T[:, :3, 3], axis=1).max() <= TOLERANCE + 1e-12
    assert np.linalg.norm((reached - T)[:, :3, :3] @ unit, axis=1).max() <= TOLERANCE + 1e-12
    assert result.rotation_error.max() > 0.1


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, 1, 1)], ids=str)
def test_an_axis_exactly_opposite_to_the_starts_is_turned_round(axis):
    """Three joints that meet in a point, and no limits: the seed points exactly the wrong way."""
    ball = Robot.from_dh([(0, 0.3, np.pi / 2, 0), (0, 0, -np.pi / 2, 0), (0, 0, 0, 0)], convention="standard")
    unit, seed = np.array(axis) / np.linalg.norm(axis), np.array([0.2, 0.5, -0.1])
    helper = np.cross(unit, (0.3, 0.5, -0.7))
    T = ball.forward_kinematics(seed)
    opposite = T.copy()
    opposite[:3, :3] = T[:3, :3] @ formulas.rotation(helper, np.pi)
    assert opposite[:3, :3] @ unit == pytest.approx(-T[:3, :3] @ unit, abs=1e-14)
    result = ball.inverse_kinematics(opposite, q_seed=seed, task=Task.pointing(axis))
    assert result.success, str(result)
    reached = ball.forward_kinematics(result.q)
    assert reached[:3, :3] @ unit == pytest.approx(opposite[:3, :3] @ unit, abs=1.01e-5)


def test_the_residual_is_reported_in_the_targets_axes_whatever_the_axis(panda, poses):
    for task in ("pose", "position", Task.pointing((1, 2, 0))):
        result = panda.inverse_kinematics(poses[:40], task=task)
        reached = panda.forward_kinematics(result.q)
        for k in range(40):
            R, rotation = poses[k, :3, :3], result.residual[k, 3:]
            assert R.T @ (poses[k] - reached[k])[:3, 3] == pytest.approx(result.residual[k, :3], abs=1e-12)
            again = R @ formulas.rotation(rotation, np.linalg.norm(rotation)).T if rotation.any() else R
            np.testing.assert_allclose(again, reached[k, :3, :3], rtol=0, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(result.residual[:, 3:], axis=1), result.rotation_error, rtol=0, atol=1e-12)


# ---- slack


SLACKS = {
    "a box": (0.02, 0.01, 0.03, 0.05, 0.1, 0.2),
    "up and down": (0.0, 0.0, 0.05, 0.0, 0.0, 0.0),
    "a plane": (FREE, FREE, 0.0, 0.0, 0.0, 0.0),
    "a tilt": (0.0, 0.0, 0.0, 0.3, 0.3, FREE),
    "orientation only": (FREE, FREE, FREE, 0.0, 0.0, 0.0),
}


def counted(slack, residual):
    """What of a residual lies beyond the slack; with the turn about z free, the tilt of z alone."""
    residual = np.array(residual)
    if np.isinf(slack[5]) and not np.isinf(slack[3]):
        R = formulas.rotation(residual[3:], np.linalg.norm(residual[3:])) if residual[3:].any() else np.eye(3)
        z = R.T[:, 2]  # the link's axis in the target's axes
        axis = np.cross(z, (0, 0, 1.0))
        size = np.linalg.norm(axis)
        residual[3:] = axis / size * np.arctan2(size, z[2]) if size > 0 else 0.0
    return np.sign(residual) * np.maximum(np.abs(residual) - slack, 0.0)


@pytest.mark.parametrize("name", SLACKS)
def test_what_lies_beyond_the_slack_is_met_and_what_lies_within_is_not_touched(panda, poses, name):
    slack = np.array(SLACKS[name])
    seeds = np.clip(np.random.default_rng(3).uniform(panda.lower, panda.upper, (N, 7)), panda.lower, panda.upper)
    result = panda.inverse_kinematics(poses, q_seed=seeds, task=Task(SLACKS[name]))
    assert_solved_within_limits(panda, result)
    left = np.array([counted(slack, residual) for residual in result.residual])
    assert np.linalg.norm(left[:, :3], axis=1).max() <= TOLERANCE + 1e-11
    assert np.linalg.norm(left[:, 3:], axis=1).max() <= TOLERANCE + 1e-9
    used = np.abs(result.residual) > 0.9 * slack
    assert used[:, (slack > 0) & np.isfinite(slack)].any(axis=0).all(), "somewhere the slack is used to its border"


def test_a_seed_within_the_slack_stays_and_one_beyond_goes_to_its_border(panda):
    T = panda.forward_kinematics(panda.home)
    inside, outside = (T @ ulna.pose((0, 0, z)) for z in (0.049, 0.2))
    task = Task((0, 0, 0.05, 0, 0, 0))
    stays = panda.inverse_kinematics(inside, q_seed=panda.home, task=task)
    assert (stays.success, stays.iterations) == (True, 0)
    assert np.array_equal(stays.q, panda.home)
    goes = panda.inverse_kinematics(outside, q_seed=panda.home, task=task)
    assert goes.success
    assert goes.residual == pytest.approx([0, 0, 0.05, 0, 0, 0], abs=1.01e-5)


def test_a_sentence_says_that_the_task_allows_what_is_left(panda):
    T, seed = panda.forward_kinematics(panda.home), panda.home
    T[0, 3] += 0.3
    wide = ulna.Task((0.5, 0.5, 0.5, 0.0, 0.0, 0.0))
    assert str(panda.inverse_kinematics(T, seed, task=wide)).startswith(
        "solved: within what the task allows, 300 mm and 0 deg from"
    )
    both = panda.inverse_kinematics([T, T], [seed, seed], task=wide)
    assert "largest errors, with what the task allows, 0.3 m" in str(both)
    assert "allows" not in str(panda.inverse_kinematics(panda.forward_kinematics(seed), seed, task=wide))
    T[:3, 3] = 5.0
    assert str(panda.inverse_kinematics(T, seed, task="position")).startswith("unreachable: ")


def test_a_joint_that_points_cannot_lift_what_a_position_asks(panda):
    beyond = ulna.pose((0.2, 0, 3.0))
    for task in ("position", "pointing", Task((0, 0, 0.1, 0, 0, 0))):
        result = panda.inverse_kinematics(beyond, task=task)
        assert result.status == "unreachable"
        assert not result.success


@pytest.mark.parametrize(
    ("slack", "axis", "message"),
    [
        ((0, 0, 0), (0, 0, 1), "slack: "),
        ((0,) * 7, (0, 0, 1), "slack: "),
        ((0, 0, -1, 0, 0, 0), (0, 0, 1), "slack: "),
        ((0, 0, np.nan, 0, 0, 0), (0, 0, 1), "slack: "),
        ("loose", (0, 0, 1), "slack: "),
        ((0, 0, 0, FREE, 0, 0), (0, 0, 1), "slack: the rotation may be free about z or altogether"),
        ((0, 0, 0, FREE, FREE, 0), (0, 0, 1), "slack: the rotation may be free about z or altogether"),
        ((FREE,) * 6, (0, 0, 1), "slack: every component is free"),
        ((0,) * 6, (0, 0, 0), "axis: "),
        ((0,) * 6, (0, 0), "axis: "),
        ((0,) * 6, (0, 0, np.inf), "axis: "),
        ((0,) * 6, (0, np.nan, 1), "axis: "),
        ((0,) * 6, "up", "axis: "),
    ],
)
def test_a_task_that_cannot_be_is_refused(slack, axis, message):
    with pytest.raises(InputError, match=f"^{message}"):
        Task(slack, axis)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0.3, -0.5, 0.2)])
def test_a_task_that_frees_nothing_asks_for_the_pose_itself_whatever_its_axis(panda, axis):
    T = panda.forward_kinematics(panda.home)
    for target in (T, T[None]):
        result = panda.inverse_kinematics(target, task=Task(axis=axis))
        assert np.all(result.success)
        np.testing.assert_allclose(panda.forward_kinematics(result.q), target, atol=3e-5)
