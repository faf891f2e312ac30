"""Arms of other makes: none of the targets they can reach is missed, judged by Pinocchio; five joints meet what five can."""

from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer, random_positions
from robot_files import EXAMPLES
from ulna import Task

ARMS = {
    "ur_description/urdf/ur5_robot.urdf": "tool0",
    "ur_description/urdf/ur10_robot.urdf": "tool0",
    "kinova_description/robots/kinova.urdf": "j2s6s200_end_effector",  # continuous joints
    "baxter_description/urdf/baxter.urdf": "left_hand_link",
    "pr2_description/urdf/pr2.urdf": "r_gripper_tool_frame",  # a prismatic torso, continuous joints
    "z1_description/urdf/z1.urdf": "gripperStator",
    "xarm_description/urdf/xarm7.urdf": "link_eef",
    "panda_description/urdf/panda.urdf": "panda_rightfinger",  # a prismatic joint, and one that mimics it
    "tiago_description/robots/tiago_no_hand.urdf": "arm_tool_link",  # a prismatic torso before the arm
    "so_arm_description/urdf/so100.urdf": "gripper",  # five joints
    "so_arm_description/urdf/so101.urdf": "gripper_frame_link",
}
FIVE_JOINTS = [path for path in ARMS if path.startswith("so_arm")]
arms = pytest.mark.parametrize("path", ARMS, ids=lambda path: Path(path).stem)
five_joints = pytest.mark.parametrize("path", FIVE_JOINTS, ids=lambda path: Path(path).stem)


@cache
def peer_of(path):
    """The robot's model in Pinocchio, which knows the robot too."""
    robot = ulna.load(EXAMPLES / path)
    return Peer(robot, pin.buildModelFromXML(robot.to_urdf()))


def pinocchio_poses(path, q):
    """The poses of the arm's end at each q, by Pinocchio."""
    return np.array([peer_of(path).link_pose(x, ARMS[path]) for x in q])


def positions_of(path, n):
    return random_positions(peer_of(path).robot, n, seed=4)


@arms
def test_every_target_is_reached_within_the_limits(path):
    robot = peer_of(path).robot
    targets = pinocchio_poses(path, positions_of(path, 200))
    result = robot.inverse_kinematics(targets, link=ARMS[path])
    assert result.success.all(), str(result)
    assert ((result.q >= robot.lower) & (result.q <= robot.upper)).all()
    reached = pinocchio_poses(path, result.q)
    assert np.linalg.norm((reached - targets)[:, :3, 3], axis=1).max() <= 1e-5 + 1e-12
    np.testing.assert_allclose(reached[:, :3, :3], targets[:, :3, :3], rtol=0, atol=1.01e-5)


@five_joints
def test_five_joints_point_along_the_target_whatever_the_turn_about_the_axis(path):
    robot = peer_of(path).robot
    goals = pinocchio_poses(path, positions_of(path, 100))
    turn = np.random.default_rng(9).uniform(-np.pi, np.pi, 100)
    targets = np.array([T @ ulna.pose((0, 0, 0), (0, 0, angle)) for T, angle in zip(goals, turn, strict=True)])
    result = robot.inverse_kinematics(targets, link=ARMS[path], task=Task.pointing())
    assert result.success.all(), str(result)
    reached = pinocchio_poses(path, result.q)
    assert np.linalg.norm((reached - targets)[:, :3, 3], axis=1).max() <= 1e-5 + 1e-12
    assert np.linalg.norm((reached - targets)[:, :3, 2], axis=1).max() <= 1e-5 + 1e-12
    assert np.abs(result.rotation_error).max() > 0.1, "and the turn that was not met is told"


@five_joints
def test_of_an_orientation_that_five_joints_cannot_reach_the_nearest_is_found(path):
    robot = peer_of(path).robot
    goals = pinocchio_poses(path, positions_of(path, 20))
    targets = np.array(
        [T @ ulna.pose((0, 0, 0), rpy) for T, rpy in zip(goals, np.random.default_rng(1).uniform(-2, 2, (20, 3)), strict=True)]
    )
    result = robot.inverse_kinematics(targets, link=ARMS[path])
    assert not result.success.any()
    reached = pinocchio_poses(path, result.q)
    np.testing.assert_allclose(result.position_error, np.linalg.norm((reached - targets)[:, :3, 3], axis=1), rtol=0, atol=1e-12)
    told = result.position_error**2 + result.rotation_error**2
    tried = pinocchio_poses(path, positions_of(path, 2000))
    nearer = 0
    for T, best in zip(targets, told, strict=True):
        angles = np.arccos(np.clip((np.einsum("nij,ij->n", tried[:, :3, :3], T[:3, :3]) - 1) / 2, -1, 1))
        others = np.linalg.norm(tried[:, :3, 3] - T[:3, 3], axis=1) ** 2 + angles**2
        nearer += others.min() < best
    assert nearer <= 1, "a local minimum is allowed, but not the rule"
