"""DH table -> robot -> DH table, and URDF -> DH table -> robot."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import formulas
import robots
import ulna
from assertions import assert_close
from robot_files import EXAMPLES
from ulna import Robot

CONVENTIONS = ("modified", "standard")
ARMS = [
    "panda_description/urdf/panda.urdf",
    "ur_description/urdf/ur3_robot.urdf",
    "ur_description/urdf/ur5_gripper.urdf",
    "ur_description/urdf/ur10_robot.urdf",
    "kinova_description/robots/kinova.urdf",
    "z1_description/urdf/z1.urdf",
    "xarm_description/urdf/xarm7.urdf",
    "so_arm_description/urdf/so101.urdf",
    "talos_data/robots/talos_left_arm.urdf",
    "baxter_description/urdf/baxter.urdf",
    "tiago_description/robots/tiago.urdf",
    "pr2_description/urdf/pr2.urdf",
    "allegro_hand_description/urdf/allegro_left_hand.urdf",
    "icub_description/robots/icub.urdf",
    "double_pendulum_description/urdf/double_pendulum.urdf",
]

length = st.one_of(st.just(0.0), st.floats(-1, 1).map(lambda x: round(x, 6)))
theta = st.one_of(st.sampled_from([0.0, pi / 2]), st.floats(-1.5, 1.5))
# No angle near 0: behind a fixed joint it tilts the next axis, and axes tilted by less than a tolerance count as parallel.
any_theta = st.one_of(st.sampled_from([0.0, pi / 2, -pi / 2, pi]), st.floats(0.01, pi), st.floats(-pi, -0.01))
alpha = st.one_of(st.sampled_from([0.0, pi / 2, -pi / 2, pi]), st.floats(0.01, 3.13), st.floats(-3.13, -0.01))
skew = st.one_of(st.floats(0.01, 3.13), st.floats(-3.13, -0.01))
any_table = st.lists(st.tuples(length, length, alpha, any_theta), min_size=1, max_size=6)
skew_table = st.lists(st.tuples(length, length, skew, theta), min_size=1, max_size=6)
kinds = st.lists(st.sampled_from(["revolute", "revolute", "prismatic", "continuous", "fixed"]), min_size=6, max_size=6)


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@given(rows=skew_table)
def test_a_table_of_skew_axes_comes_back_number_for_number(convention, rows):
    table = Robot.from_dh(rows, convention=convention).dh(convention=convention)
    assert_close(table.rows, rows, atol=1e-12)
    assert_close([table.T_base_0, table.T_n_tip], [np.eye(4)] * 2, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("target", CONVENTIONS)
@pytest.mark.parametrize("convention", CONVENTIONS)
@given(rows=any_table, kinds=kinds, seed=st.integers(0, 2**32 - 1))
def test_any_table_becomes_one_of_the_same_robot_in_either_convention(convention, target, rows, kinds, seed):
    kinds = kinds[: len(rows)]
    table = Robot.from_dh(rows, convention=convention, joint_types=kinds).dh(convention=target)
    assert table.joint_types == tuple(kind for kind in kinds if kind != "fixed")
    for q in np.random.default_rng(seed).uniform(-3, 3, (3, len(table.rows))):
        expected = formulas.dh_poses(rows, kinds, q, convention)[-1]
        written_out = [np.eye(4), *formulas.dh_poses(table.rows, table.joint_types, q, target)][-1]
        assert_close(table.T_base_0 @ written_out @ table.T_n_tip, expected, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("convention", CONVENTIONS)
@given(rows=any_table, kinds=kinds)
def test_the_table_of_a_tables_robot_is_that_table(convention, rows, kinds):
    table = Robot.from_dh(rows, convention=convention, joint_types=kinds[: len(rows)]).dh(convention=convention)
    again = Robot.from_dh(table).dh(convention=convention)
    assert_close(again.rows, table.rows, atol=1e-9)
    assert_close([again.T_base_0, again.T_n_tip], [table.T_base_0, table.T_n_tip], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("path", ARMS, ids=lambda path: Path(path).stem)
def test_every_chain_of_a_real_robot_is_its_table(path):
    robot = ulna.load(EXAMPLES / path)
    for leaf in robot.tree.leaves:
        for convention in CONVENTIONS:
            table = robot.dh(convention=convention, link=leaf)
            assert table.max_position_difference < 1e-12, leaf
            assert table.max_rotation_difference < 1e-12, leaf
            assert np.abs(table.rows[:, :2]).max(initial=0.0) < 2, leaf
            rebuilt = Robot.from_dh(table)
            columns = [robot.joint_names.index(name) if name in robot.joint_names else -1 for name in rebuilt.joint_names]
            if -1 in columns:  # a finger that follows a joint of another chain has a number of its own here
                continue
            q = np.random.default_rng(5).uniform(-3, 3, (10, robot.n_dof))
            starts = [robot.joint_slices[column].start for column in columns]
            assert_close(rebuilt.forward_kinematics(q[:, starts]), robot.forward_kinematics(q, link=leaf), atol=1e-12)


def test_the_ur5_of_universal_robots_is_the_published_table_turned_by_half_a_turn():
    """ROS turns the base by pi about z; seen from there every x axis of the published table points the other way."""
    robot = ulna.load(EXAMPLES / "ur_description/urdf/ur5_robot.urdf")
    table = robot.dh(convention="standard", link="ee_link")
    published = np.array(robots.UR5)
    assert_close(table.rows[:5, :3], published[:5, :3] * [-1, 1, -1], atol=1e-15)
    assert_close(table.rows[5, :2], published[5, :2])
    turned = Robot.from_dh(published, convention="standard", T_base_0=ulna.pose(rpy=(0, 0, pi)))
    q = np.random.default_rng(6).uniform(-3, 3, (100, 6))
    flange, tip = turned.forward_kinematics(q), robot.forward_kinematics(q, link="ee_link")
    apart = np.linalg.inv(flange) @ tip
    assert_close(apart, np.broadcast_to(apart[0], apart.shape), atol=1e-10)  # the file's 1.570796325 is 1.8e-9 off
    assert_close(apart[:, :3, 3], np.zeros((100, 3)), atol=1e-10)
