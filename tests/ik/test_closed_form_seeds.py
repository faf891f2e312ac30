"""``inverse_kinematics`` with a seed that is a solution, or nearly: it returns that one, also where arms are singular."""

import numpy as np
import pytest

import robots
from ulna import Robot

QUARTER = np.pi / 2
WRIST = 0.05  # m
PUMA = ((0, 0, QUARTER, 0), (0.4318, 0, 0, 0), (0.0203, 0.15005, -QUARTER, 0), (0, 0.4318, QUARTER, 0), (0, 0, -QUARTER, 0),
        (0, WRIST, 0, 0))  # fmt: skip


def arm(rows):
    return Robot.from_dh([tuple(row) for row in rows], convention="standard", limits=[(-2 * np.pi, 2 * np.pi)] * 6)


def assert_bits_of_single_calls(robot, T, seeds, found):
    for k in range(0, len(T), 37):
        np.testing.assert_array_equal(robot.inverse_kinematics(T[k], seeds[k]).q, found.q[k])


@pytest.mark.parametrize("rows", [PUMA, robots.UR5], ids=["Puma", "UR5"])
def test_where_several_singularities_meet_a_seed_that_is_a_solution_is_the_answer(rows):
    robot, rng = arm(rows), np.random.default_rng(1)
    corners = rng.integers(-2, 3, (800, 6)) * QUARTER
    T = robot.forward_kinematics(corners)
    found = robot.inverse_kinematics(T, corners)
    assert found.success.all()
    assert np.abs(found.q - corners).max() < 1e-6
    assert_bits_of_single_calls(robot, T, corners, found)


def test_near_such_a_corner_the_answer_is_as_near_as_the_seed_allows():
    robot, rng = arm(PUMA), np.random.default_rng(2)
    corners = rng.integers(-2, 3, (800, 6)) * QUARTER
    T, seeds = robot.forward_kinematics(corners), corners + rng.normal(0, 2e-4, corners.shape)
    found = robot.inverse_kinematics(T, seeds)
    assert found.success.all()
    assert np.abs(found.q - seeds).max() < 5e-3
    assert_bits_of_single_calls(robot, T, seeds, found)


@pytest.mark.parametrize("off", [9e-4, 1e-5, 1e-7])
def test_an_arm_that_is_nearly_of_a_family_stays_on_the_branch_of_its_seed_near_a_straight_wrist(off):
    rng = np.random.default_rng(3)
    rows = np.array(robots.UR5E) + rng.uniform(-off, off, (6, 4)) * [0.5, 0.5, 0.5, 0.0]
    robot = arm(rows)
    form = robot.closed_form
    assert form is not None
    assert not form.is_exact
    q = rng.uniform(-np.pi, np.pi, (3000, 6))
    q[:, 4] = rng.choice([0, np.pi, -np.pi], 3000) + rng.normal(0, 1e-2, 3000) * 10 ** rng.uniform(-6, 0, 3000)
    T = robot.forward_kinematics(q)
    found = robot.inverse_kinematics(T, q)
    assert found.success.all()
    assert np.abs(found.q - q).max() < 1e-6
    assert_bits_of_single_calls(robot, T, q, found)
