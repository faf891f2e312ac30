"""The node of ROS 2, and a second process that subscribes to its topics and drags the box: real rclpy, on loopback."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS 2 for this Python: docs/ros.md says how to install it")
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate, MarkerArray
from visualization_msgs.srv import GetInteractiveMarkers

import ulna
from processes import PATIENCE_S, ends_while_it_compiles, running
from ulna.demo.ros.messages import pose_message, pose_of
from ulna.demo.ros.ros2 import transforms
from ulna.description.pose import pose
from ulna.viewer.palette import GREEN, RED

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of ROS's own modules, imported as they are needed


@pytest.fixture(scope="module")
def machine():
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)  # not another test's node
    return dict(os.environ)


@pytest.fixture(scope="module")
def demo(machine):
    with running(
        sys.executable, "-m", "ulna", "ros2", "demo", env=machine, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as node:
        yield node


@pytest.fixture(scope="module")
def listener(demo):
    rclpy.init()
    yield Listener()
    rclpy.try_shutdown()


class Listener:
    """The second process: the last message of each topic, and a publisher that drags the box."""

    def __init__(self):
        self.node = rclpy.create_node("listener")
        self.received = {}
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for topic, kind, quality in (
            ("joint_states", JointState, 10),
            ("visualization_marker_array", MarkerArray, 10),
            ("basic_controls/update", InteractiveMarkerUpdate, 10),
            ("robot_description", String, kept),
        ):
            self.node.create_subscription(
                kind, topic, lambda message, topic=topic: self.received.update({topic: message}), quality
            )
        self.hand = self.node.create_publisher(InteractiveMarkerFeedback, "basic_controls/feedback", 10)
        self.handles = self.node.create_client(GetInteractiveMarkers, "basic_controls/get_interactive_markers")

    def wait_for(self, condition, what):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, f"not received within {PATIENCE_S:g} s: {what}"
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def drag(self, place: Pose, name="box"):
        self.wait_for(lambda: self.hand.get_subscription_count() > 0, "a server of handles")
        self.hand.publish(InteractiveMarkerFeedback(header=Header(frame_id="panda_link0"), marker_name=name, pose=place))

    def wait_for_box(self, place):
        """Wait until the handles are told of the box at a pose. Another topic may have shown its effect before."""

        def is_there():
            poses = getattr(self.received.get("basic_controls/update"), "poses", ())
            return len(poses) > 0 and np.allclose(pose_of(poses[0].pose), place)

        self.wait_for(is_there, "where the box stands")

    def light(self):
        """The light's color, 0 to 255, and its text."""
        self.wait_for(lambda: "visualization_marker_array" in self.received, "markers")
        light, word = self.received["visualization_marker_array"].markers[:2]
        return tuple(round(255 * c) for c in (light.color.r, light.color.g, light.color.b)), word.text


def test_joint_states_follow_the_trajectory(listener):
    listener.wait_for(lambda: "joint_states" in listener.received, "joint states")
    first = listener.received["joint_states"]
    assert list(first.name) == [*(f"panda_joint{k}" for k in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]
    listener.wait_for(
        lambda: not np.allclose(listener.received["joint_states"].position, first.position, atol=0.01), "a moving arm"
    )


def test_the_description_is_sent_to_an_rviz_that_starts_later(listener):
    listener.wait_for(lambda: "robot_description" in listener.received, "the description")
    described = ulna.load(listener.received["robot_description"].data)
    listener.wait_for(lambda: "joint_states" in listener.received, "joint states")
    state = listener.received["joint_states"]
    assert described.joint_names == tuple(state.name)
    poses = described.link_poses(described.q_of_joints(state.name, state.position))
    assert {"panda_link7", "panda_leftfinger"} < {found.child_frame_id for found in transforms(described, poses, Time())}


def test_the_light_changes_when_the_box_is_moved(listener):
    listener.wait_for(lambda: "visualization_marker_array" in listener.received, "markers")
    assert len(listener.received["visualization_marker_array"].markers) == 14
    listener.wait_for(lambda: listener.light() == (GREEN, "free"), "a green light")
    listener.drag(pose_message(pose((0, 0, 0.1))))
    listener.wait_for(lambda: listener.light()[0] == RED, "a red light")
    assert "box 1" in listener.light()[1]
    listener.wait_for_box(pose((0, 0, 0.1)))
    listener.drag(pose_message(pose((0, 0.8, 0.1))))
    listener.wait_for(lambda: listener.light() == (GREEN, "free"), "a green light again")


def test_the_marker_name_of_the_course_is_accepted(listener):
    listener.drag(pose_message(pose((0, 0, 0.1))), name="simple_6dof")
    listener.wait_for(lambda: listener.light()[0] == RED, "a red light")


def test_an_orientation_that_is_not_set_is_none(listener):
    listener.drag(Pose(position=Point(z=0.1), orientation=Quaternion(w=0.0)))
    listener.wait_for(lambda: listener.light()[0] == RED, "a red light")
    listener.drag(Pose(position=Point(y=0.8, z=0.1), orientation=Quaternion(w=0.0)))
    listener.wait_for(lambda: listener.light() == (GREEN, "free"), "a green light")


def test_an_invalid_pose_is_undone_and_the_node_continues(listener):
    listener.drag(pose_message(pose((0, 0, 0.1))))
    listener.wait_for(lambda: listener.light()[0] == RED, "a red light")
    listener.wait_for_box(pose((0, 0, 0.1)))
    listener.received.pop("basic_controls/update")
    listener.drag(Pose(position=Point(x=np.nan)))
    listener.wait_for(lambda: "basic_controls/update" in listener.received, "the box put back")
    np.testing.assert_allclose(pose_of(listener.received["basic_controls/update"].poses[0].pose), pose((0, 0, 0.1)))
    listener.drag(pose_message(pose((0, 0.8, 0.1))))
    listener.wait_for(lambda: listener.light() == (GREEN, "free"), "a green light")


def test_an_rviz_that_starts_later_gets_the_handles(listener):
    asked = listener.handles.call_async(GetInteractiveMarkers.Request())
    listener.wait_for(asked.done, "the handles")
    (box,) = asked.result().markers
    assert [control.name for control in box.controls[1:]] == [f"{verb}_{axis}" for axis in "xyz" for verb in ("move", "rotate")]
    assert box.header.frame_id == "panda_link0"


def test_without_tf2_msgs_the_node_runs_with_a_message(machine):
    code = "import sys; sys.modules['tf2_msgs'] = None; from ulna.cli.app import app; app(['ros2', 'demo'])"
    with running(sys.executable, "-c", code, env=machine, stderr=subprocess.PIPE) as node:
        lines = []
        for line in node.stderr:
            lines.append(line)
            if "the demo runs" in line:
                break
        node.send_signal(signal.SIGINT)
        lines += node.stderr
        assert node.wait(PATIENCE_S) == 0, "".join(lines)
    assert "the module tf2_msgs is missing" in "".join(lines)
    assert "Traceback" not in "".join(lines)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("before", ["draw_arm", "draw_report", "get_clock", "create_service", "create_timer"])
def test_a_signal_at_any_moment_ends_the_node_quietly(machine, before, number):
    """rclpy's own handlers end its context from another thread: whatever the node does next raises."""
    code = f"""
import os, sys, time
from ulna.demo.ros.ros2 import DemoNode
usual = DemoNode.{before}
def interrupted(*args, **options):
    DemoNode.{before} = usual
    os.kill(os.getpid(), {int(number)})
    time.sleep(0.1)
    return usual(*args, **options)
DemoNode.{before} = interrupted
from ulna.cli.app import app
app(['ros2', 'demo'])
"""
    ended = subprocess.run(
        [sys.executable, "-c", code], env=machine, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert "Traceback" not in ended.stderr


def test_ctrl_c_does_not_wait_for_the_compiler(machine, tmp_path):
    ends_while_it_compiles(["-m", "ulna", "ros2", "demo"], machine, tmp_path)
