"""``all_solutions`` of ``robot.on_gpu()`` against that of the robot on the CPU: on a GPU, or with simulated threads.

See ``test_gpu_robot.py``.
"""

import os

import numpy as np
import pytest

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from numba import cuda

import robots
import ulna
from closed_form_arms import FAMILIES, NAMES, arm_of
from ulna.gpu.queue import Queue
from ulna.gpu.solutions import _run
from ulna.ik.closed_form.closed_form import closed_form_of, joints_at

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"
N = 5 if SIMULATED else 10_000
FEW = 2 if SIMULATED else 200
if not cuda.is_available():
    pytest.skip("there is no GPU: make test-cuda simulates one", allow_module_level=True)


def ur5(limit=np.pi):
    return ulna.Robot.from_dh(robots.UR5, convention="standard", limits=[(-limit, limit)] * 6)


def targets_of(robot, n, seed=0):
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return robot.forward_kinematics(np.random.default_rng(seed).uniform(low, high, (n, robot.n_dof)))


def assert_same(found, expected, most=1e-9):
    """The same branches in the same order, with the same proofs."""
    assert (found.family, found.q.shape) == (expected.family, expected.q.shape)
    assert (found.real == expected.real).all()
    assert (found.valid == expected.valid).all()
    assert np.array_equal(found.proof, expected.proof)
    np.testing.assert_allclose(found.q, expected.q, rtol=0, atol=most)


@pytest.mark.parametrize("from_end", [False, True])
@pytest.mark.parametrize("family", FAMILIES, ids=NAMES.get)
def test_the_branches_of_every_family_are_those_of_the_cpu(family, from_end):
    robot = arm_of(family, np.random.default_rng([family, 7]), from_end=from_end)
    T = targets_of(robot, N)
    found = robot.on_gpu().all_solutions(T)
    assert_same(found, robot.all_solutions(T), 1e-6)
    reached = robot.forward_kinematics(found.q[found.real])
    assert np.abs(reached - np.repeat(T, found.real.sum(axis=1), axis=0)).max() < 1e-9


def test_each_joint_has_its_own_entry_of_q():
    robot, order = ur5(), np.array([3, 0, 5, 1, 4, 2])
    T, form = targets_of(robot, N), closed_form_of(robot.tree, robot.tip)
    six = joints_at(form, robot.home)
    plan = six.plan(robot.lower, robot.upper)
    found, plain = (_run(Queue(), six, T, robot.home[None], plan, columns)[0] for columns in (order, np.arange(6)))
    np.testing.assert_array_equal(found[..., order], plain)


@pytest.mark.parametrize("limit", [1.5, np.pi, 2 * np.pi])
def test_branches_are_turned_within_the_limits_as_on_the_cpu(limit):
    robot = ur5(limit)
    T = targets_of(robot, N)
    assert_same(robot.on_gpu().all_solutions(T), robot.all_solutions(T))


def test_whole_turns_are_listed_as_on_the_cpu():
    robot = ur5(2 * np.pi)
    T = targets_of(robot, FEW)
    assert_same(robot.on_gpu().all_solutions(T, whole_turns=True), robot.all_solutions(T, whole_turns=True))


@pytest.mark.parametrize("redundancy", [None, "panda_joint4", "panda_joint7"])
def test_seven_joints_are_solved_at_places_of_the_one_that_is_held(redundancy):
    robot = ulna.load("panda")
    T = targets_of(robot, FEW)
    found = robot.on_gpu().all_solutions(T, redundancy=redundancy, n_samples=3)
    assert_same(found, robot.all_solutions(T, redundancy=redundancy, n_samples=3), 1e-6)
    assert found.q.shape[1] in {24, 24 + 3}  # eight at each of three places; where these give none, three that a search finds


def test_a_position_and_a_pointing_are_tasks():
    three = ulna.Robot.from_dh(robots.UR5[:3], convention="standard")
    five = ulna.Robot.from_dh(robots.UR5[:5], convention="standard")
    for robot, task in ((three, "position"), (five, "pointing"), (three, "pose")):
        T = targets_of(robot, FEW)
        found = robot.on_gpu().all_solutions(T, task=task)
        assert_same(found, robot.all_solutions(T, task=task), 1e-6)
        assert found.valid.any(axis=1).all()


def test_an_arm_without_a_closed_form_is_searched_by_the_cpu():
    rng = np.random.default_rng(5)
    robot = ulna.Robot.from_dh(np.column_stack([*rng.uniform(0.1, 0.4, (2, 4)), rng.uniform(0.3, 1.2, 4), np.zeros(4)]))
    T = targets_of(robot, 1)
    found = robot.on_gpu().all_solutions(T, task="position")
    assert_same(found, robot.all_solutions(T, task="position"))
    assert set(found.proof) == {"searched"}
    assert found.valid.any()


def test_arrays_on_the_device_stay_there():
    robot = ur5()
    T = targets_of(robot, 6).reshape(2, 3, 4, 4)
    found, expected = robot.on_gpu().all_solutions(cuda.to_device(T)), robot.all_solutions(T)
    assert all(hasattr(array, "copy_to_host") for array in (found.q, found.valid, found.real))
    assert_same(found.copy_to_host(), expected)
    assert found.proof.shape == (2, 3)
    assert str(found) == str(expected)
    one = robot.on_gpu().all_solutions(cuda.to_device(T[0, 0]))
    assert (tuple(one.q.shape), one.proof) == ((8, 6), "complete")


def test_arrays_on_the_device_may_be_copied_for_an_arm_that_needs_the_cpu():
    robot = ulna.load("panda")
    T = targets_of(robot, 1)
    found = robot.on_gpu().all_solutions(cuda.to_device(T), n_samples=2)
    assert hasattr(found.q, "copy_to_host")
    assert_same(found.copy_to_host(), robot.all_solutions(T, n_samples=2), 1e-6)


def test_one_target_none_and_what_is_no_pose():
    robot = ur5()
    on_gpu, T = robot.on_gpu(), targets_of(robot, 3)
    one, expected = on_gpu.all_solutions(T[0]), robot.all_solutions(T[0])
    assert (one.q.shape, one.proof) == ((8, 6), expected.proof)
    np.testing.assert_allclose(one.q, expected.q, rtol=0, atol=1e-9)
    assert on_gpu.all_solutions(T[:0]).q.shape == (0, 8, 6)
    T[1] *= 2.0
    for bad in (T, cuda.to_device(T)):
        with pytest.raises(ulna.InputError, match=r"T\[1\]"):
            on_gpu.all_solutions(bad)
    with pytest.raises(ulna.InputError, match="n_samples"):
        on_gpu.all_solutions(T, n_samples=0)
    with pytest.raises(ulna.InputError, match="redundancy"):
        on_gpu.all_solutions(T, redundancy="elbow")
