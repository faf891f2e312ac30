"""A robot of a running ROS 2: its joints by name, and a motion as a message, with the classes of the real ROS."""

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS 2 for this Python: docs/ros.md says how to install it")
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

import ulna

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of ROS's own modules, imported as they are needed


def test_joint_states_are_a_configuration_and_a_motion_is_a_message():
    arm = ulna.load("panda")
    state = JointState(name=["a_finger", *reversed(arm.joint_names)], position=[0.02, *reversed(arm.home.tolist())])
    q = arm.q_of_joints(state.name, state.position)
    assert np.array_equal(q, arm.home)
    message = arm.plan(q, q + 0.1).trajectory(acceleration=3.0).to_ros()
    assert isinstance(message, JointTrajectory)
    np.testing.assert_allclose(message.points[-1].positions, q + 0.1, atol=1e-9)
