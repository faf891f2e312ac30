"""A robot of any size, in any unit, is solved as one of a meter is: nothing measures a length against an angle."""

import numpy as np
import pytest

import robots
import ulna
from ik_methods import valid_solutions
from ulna import Robot

LIMITS = [(-2 * np.pi, 2 * np.pi)] * 6
SIZES = [2.0**-17, 2.0**-13, 2.0**-10, 2.0**10, 2.0**14]


def ur5(size):
    return Robot.from_dh(np.array(robots.UR5) * (size, size, 1, 1), convention="standard", limits=LIMITS)


def scara_on_rails(size):
    """Two slides, one of them long, that carry two turns, a slide and a turn."""
    rows = [(0, 0.1, 0, 0), (0.2, 0, np.pi / 2, 0), (0.1, 0.3, 0.4, 0), (0.4, 0, 0, 0), (0.3, 0.2, 0, 0), (0, 0, np.pi / 2, 0)]
    kinds = ["prismatic", "prismatic", "revolute", "revolute", "prismatic", "revolute"]
    limits = [(-50 * size, 50 * size), (0, size), (-2, 2), (-2, 2), (0, 0.3 * size), (-3, 3)]
    return Robot.from_dh(np.array(rows) * (size, size, 1, 1), joint_types=kinds, limits=limits)


@pytest.mark.parametrize("size", [1.0, 1e-2, *SIZES])
@pytest.mark.parametrize("make", [ur5, scara_on_rails])
@pytest.mark.parametrize("task", ["pose", "pointing"])
def test_every_target_within_reach_is_solved(rng, make, size, task):
    robot = make(size)
    T = robot.forward_kinematics(rng.uniform(np.maximum(robot.lower, -50 * size - 3), robot.upper, (60, 6)))
    result = robot.inverse_kinematics(T, task=task, position_tolerance=1e-5 * size)
    assert (result.status == "solved").all(), str(result)
    off = np.linalg.norm(robot.forward_kinematics(result.q)[:, :3, 3] - T[:, :3, 3], axis=1)
    np.testing.assert_allclose(result.position_error, off, rtol=1e-6, atol=1e-9 * size)
    assert (off <= 1.001e-5 * size).all()
    assert ((robot.lower <= result.q) & (result.q <= robot.upper)).all()
    alone = robot.inverse_kinematics(T[0], task=task, position_tolerance=1e-5 * size)
    assert alone.success


def test_the_same_robot_in_another_unit_goes_the_same_way_to_the_bit(rng):
    q, seeds = rng.uniform(-3, 3, (20, 6)), rng.uniform(-3, 3, (20, 6))
    results = []
    for size in SIZES:
        robot = ur5(size)
        T = robot.forward_kinematics(q)
        T[:10, :3, 3] += 2.0 * size  # some of them out of reach
        results.append(robot.inverse_kinematics(T, seeds, position_tolerance=1e-5 * size))
    for result in results[1:]:
        assert result.status.tolist() == results[0].status.tolist()
        assert result.q.tobytes() == results[0].q.tobytes()


@pytest.mark.parametrize("size", [2.0**-17, 1.0, 2.0**10])
def test_the_reason_does_not_depend_on_the_size(size):
    """A centimeter beyond the stretched arm, which the closed form proves, and the bound of the reach not; and one far away."""
    robot = ur5(size)
    q = np.array([0, -0.5, 0, -1, -1.5, 0])
    T = robot.forward_kinematics(q)
    out = robot.forward_kinematics(q, link="link3")[:3, 3] - robot.forward_kinematics(q, link="link1")[:3, 3]
    T[:3, 3] += 0.01 * size * out / np.linalg.norm(out)
    result = robot.inverse_kinematics(T, position_tolerance=1e-5 * size)
    assert (result.status, result.reach_excess) == ("unreachable", 0.0)
    assert str(result.reason).startswith("the closed form has no solution")
    assert robot.inverse_kinematics(ulna.pose((9e5, 0, 0))).status == "unreachable"


@pytest.mark.parametrize("size", [2.0**-13, 1.0, 2.0**10])
def test_all_solutions_are_as_many_in_any_size(size):
    robot = ur5(size)
    T = robot.forward_kinematics([0.3, -1.0, 1.2, -0.7, 1.1, 0.4])
    found = valid_solutions(robot, T, position_tolerance=1e-5 * size)
    assert len(found) == 8
    np.testing.assert_allclose(robot.forward_kinematics(found)[:, :3, 3], np.tile(T[:3, 3], (8, 1)), rtol=0, atol=1e-8 * size)


@pytest.mark.parametrize("size", [2.0**-17, 2.0**12])
def test_a_slide_with_limits_as_large_as_numbers_go_is_one_without(size):
    rows = np.array([(0, 0.1, 0, 0), (0.2, 0, np.pi / 2, 0), (0.1, 0.3, 0.4, 0)]) * (size, size, 1, 1)
    kinds, limits = ["prismatic", "revolute", "revolute"], [(-1.7e308, 1.7e308), (-2, 2), (-2, 2)]
    robot = Robot.from_dh(rows, joint_types=kinds, limits=limits)
    T = robot.forward_kinematics([3.0 * size, 0.4, -0.7])
    assert robot.inverse_kinematics(T, position_tolerance=1e-6 * size).success
