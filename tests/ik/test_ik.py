"""Inverse kinematics, judged by Pinocchio: where the answer really puts the link, and whether the result says so truly."""

import numpy as np
import pinocchio as pin
import pytest

import robots
import ulna
from ulna import InputError


def random_positions(robot, n: int, seed: int = 4) -> np.ndarray:
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (n, robot.n_dof))


class Judge:
    """Distance and angle from a target, by Pinocchio."""

    def __init__(self, robot) -> None:
        self.model = pin.buildModelFromXML(robot.to_urdf())
        self.data = self.model.createData()

    def pose(self, q, link="panda_ee") -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, np.asarray(q, dtype=float))
        return self.data.oMf[self.model.getFrameId(link)].homogeneous.copy()

    def errors(self, q, target) -> tuple[float, float]:
        T = self.pose(q)
        return float(np.linalg.norm(target[:3, 3] - T[:3, 3])), float(np.linalg.norm(pin.log3(T[:3, :3].T @ target[:3, :3])))


@pytest.fixture(scope="module")
def judge(panda):
    return Judge(panda)


def shifted(T: np.ndarray, xyz) -> np.ndarray:
    T = T.copy()
    T[..., :3, 3] += xyz
    return T


def assert_within_limits(robot, q) -> None:
    assert np.isfinite(q).all()
    assert (q >= robot.lower).all()
    assert (q <= robot.upper).all()


def test_the_errors_that_are_reported_are_those_that_pinocchio_finds(panda, judge):
    targets = np.array([judge.pose(q) for q in random_positions(panda, 1000)])
    result = panda.inverse_kinematics(targets)
    assert result.success.all()
    assert (result.status == "solved").all()
    assert_within_limits(panda, result.q)
    errors = np.array([judge.errors(q, T) for q, T in zip(result.q, targets, strict=True)])
    assert errors.max() <= 1e-5 + 1e-12
    np.testing.assert_allclose(result.position_error, errors[:, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(result.rotation_error, errors[:, 1], rtol=0, atol=1e-8)


def test_a_finer_tolerance_is_kept(panda, judge):
    targets = panda.forward_kinematics(random_positions(panda, 200))
    result = panda.inverse_kinematics(targets, position_tolerance=1e-9, rotation_tolerance=1e-8)
    assert result.success.all()
    assert result.tolerances == (1e-9, 1e-8)
    for q, T in zip(result.q, targets, strict=True):
        position, rotation = judge.errors(q, T)
        assert position <= 1e-9 + 1e-13
        assert rotation <= 1e-8 + 1e-9


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_a_target_in_the_corner_of_all_limits_is_reached(panda, judge, end):
    target = judge.pose(getattr(panda, end))
    result = panda.inverse_kinematics(target)
    assert result.success
    assert_within_limits(panda, result.q)
    assert max(judge.errors(result.q, target)) <= 1e-5


@pytest.mark.parametrize("away", [(3.0, 0, 0), (0, 0, -50.0), (1e5, -1e5, 1e5)], ids=["3 m", "50 m", "100 km"])
def test_a_target_out_of_reach_is_a_result_that_reports_its_true_errors(panda, judge, away):
    target = shifted(judge.pose(panda.home), away)
    result = panda.inverse_kinematics(target)
    assert not result.success
    assert result.status == "unreachable"
    assert_within_limits(panda, result.q)
    position, rotation = judge.errors(result.q, target)
    assert position > 1.0
    assert result.position_error == pytest.approx(position, rel=1e-12)
    assert result.rotation_error == pytest.approx(rotation, abs=1e-7)
    assert str(result).startswith(f"{result.status}: ")
    nearest = panda.inverse_kinematics(target, task="position")
    assert 1.0 < nearest.reach_excess <= nearest.position_error


def test_a_target_too_far_to_compute_with_is_refused(panda):
    for far in (1e7, 1e200):
        with pytest.raises(InputError, match=r"^T: has a position beyond 1e\+06 m"):
            panda.inverse_kinematics(shifted(panda.forward_kinematics(panda.home), far))


def test_in_a_batch_each_target_ends_on_its_own(panda):
    good = panda.forward_kinematics(panda.home)
    result = panda.inverse_kinematics([good, shifted(good, (0, 3, 0)), good])
    assert result.success.tolist() == [True, False, True]
    assert result.status.tolist() == ["solved", "unreachable", "solved"]
    assert str(result).startswith("2 of 3 targets solved (1 unreachable)")


@pytest.mark.parametrize("batch", [(), (1,), (5,), (9,), (2, 3), (1, 1, 1), (0,), (2, 0)], ids=str)
def test_the_axes_of_a_batch_come_back_unchanged(panda, batch):
    T = panda.forward_kinematics(np.broadcast_to(panda.home + 0.01, (*batch, 7)))
    result = panda.inverse_kinematics(T)
    assert result.q.shape == (*batch, 7)
    for name in ("success", "status", "position_error", "rotation_error", "iterations"):
        assert np.shape(getattr(result, name)) == batch, name
    assert np.all(result.success)
    assert isinstance(str(result), str)


def test_targets_as_nested_lists_are_as_good_as_arrays_and_are_not_changed(panda):
    T = panda.forward_kinematics(panda.home + 0.05)
    before = T.copy()
    as_list = panda.inverse_kinematics(T.tolist(), q_seed=panda.home.tolist())
    as_array = panda.inverse_kinematics(np.asfortranarray(T), q_seed=panda.home)
    assert np.array_equal(as_list.q, as_array.q)
    assert np.array_equal(T, before)


@pytest.mark.parametrize("limit", [1e3, 1e9, 1e16], ids=lambda limit: f"{limit:g}")
def test_very_wide_limits_do_not_scatter_the_search(limit):
    """Descriptions write 1e16 for "no limit" (iris.urdf does); the answers must be angles that can be used again."""
    arm = ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-limit, limit)] * 6)
    targets = arm.forward_kinematics(np.random.default_rng(5).uniform(-3, 3, (100, 6)))
    result = arm.inverse_kinematics(targets)
    assert result.success.all()
    np.testing.assert_allclose(arm.forward_kinematics(result.q), targets, rtol=0, atol=3e-5)
