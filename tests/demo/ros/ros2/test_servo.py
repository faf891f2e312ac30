"""The servo as a node of ROS 2, and a second process that sends it the commands of MoveIt Servo: real rclpy, on loopback."""

import os
import sys
import time
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS 2 for this Python: docs/ros.md says how to install it")
import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, Header, String
from trajectory_msgs.msg import JointTrajectory

import ulna
from processes import PATIENCE_S, running
from ulna.demo.ros.messages import pose_message
from ulna.demo.ros.servo_node import ServoNode
from ulna.demo.ros.servo_settings import Output, Settings

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of ROS's own modules, imported as they are needed
WALL = "0.65, 0, 0.5, 0, 0, 0, 0.1, 2, 2"
TRAJECTORY, POSITIONS = "/joint_trajectory_controller/joint_trajectory", "/forward_position_controller/commands"


@pytest.fixture(scope="module")
def machine():
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(101 + os.getpid() % 100)  # not another test's node
    rclpy.init()
    yield dict(os.environ)
    rclpy.try_shutdown()


@pytest.fixture(scope="module")
def panda():
    return ulna.load("panda")


@pytest.fixture(params=["trajectory", "positions"])
def user(request, machine, panda):
    """A user of a node that steers the Panda, whose joint states are the last command."""
    with running(
        *(sys.executable, "-m", "ulna", "ros2", "servo", "panda", "--box", WALL, "--output", request.param), env=machine
    ):
        someone = User(panda)
        yield someone
        someone.node.destroy_node()


class User:
    """Publishes commands, and the state of an arm that does what the node sends."""

    def __init__(self, robot):
        self.robot, self.q, self.commands, self.statuses = robot, robot.home, [], []
        self.node = rclpy.create_node("user")
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node.create_subscription(JointTrajectory, TRAJECTORY, self.follow_trajectory, 10)
        self.node.create_subscription(Float64MultiArray, POSITIONS, lambda message: self.follow(message.data), 10)
        self.node.create_subscription(String, "/servo_node/status", lambda message: self.statuses.append(message.data), kept)
        self.states = self.node.create_publisher(JointState, "/joint_states", 10)
        self.twists = self.node.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
        self.poses = self.node.create_publisher(PoseStamped, "/servo_node/pose_target_cmds", 10)

    def follow_trajectory(self, message):
        (point,) = message.points
        assert list(message.joint_names) == list(self.robot.joint_names)
        assert point.time_from_start.nanosec == 10_000_000
        assert len(point.velocities) == len(point.accelerations) == 7
        self.follow(point.positions)

    def follow(self, q):
        self.commands.append(np.array(q))
        self.q = self.commands[-1]

    def until(self, condition, what, send=lambda: None):
        """Send and listen until something holds."""
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, f"not seen within {PATIENCE_S:g} s: {what}; {self.statuses[-3:]}"
            self.states.publish(JointState(name=list(self.robot.joint_names), position=list(self.q)))
            send()
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def listen(self, seconds):
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "some time")

    def send_twist(self, v, frame=""):
        message = TwistStamped()
        message.header.frame_id = frame
        message.twist.linear.x, message.twist.linear.y, message.twist.linear.z = v
        self.twists.publish(message)

    def send_pose(self, T, frame=""):
        message = PoseStamped(pose=pose_message(T))
        message.header.frame_id = frame
        self.poses.publish(message)

    @property
    def status(self):
        return self.statuses[-1] if self.statuses else ""

    @property
    def hand(self):
        return self.robot.forward_kinematics(self.q)


@contextmanager
def node_of(panda, world=None, tracking_error=0.0, jerk=None):
    """A node that has measured the arm at home, and compiles at once."""
    settings = Settings(panda.tip, 100, 5.0, jerk, 0.01, tracking_error, Output.POSITIONS, None)
    node = ServoNode(panda, world, settings, lambda _, do, *of: do(*of))
    try:
        node._measure(JointState(name=list(panda.joint_names), position=list(panda.home)))
        yield node
    finally:
        node.destroy_node()


def test_twists_and_poses_move_the_hand_and_it_stops_before_the_wall(user, panda):
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2, 2)), ulna.pose((0.65, 0, 0.5)))
    user.until(lambda: user.status == "at rest", "a node that has started")
    before = user.hand
    user.until(lambda: "limited by clearance" in user.status, "the wall", lambda: user.send_twist((0.2, 0.0, 0.0)))
    assert "box 1" in user.status
    assert user.hand[0, 3] > before[0, 3] + 0.01
    user.until(lambda: user.status == "at rest", "rest without commands")  # after the timeout
    user.listen(1.0)
    n = len(user.commands)
    user.listen(0.5)
    assert len(user.commands) == n  # at rest nothing is sent
    goal = before @ ulna.pose((0, 0.05, 0.05), (0.1, 0.2, 0))
    user.until(lambda: np.abs(user.hand - goal).max() < 1e-4, "the pose", lambda: user.send_pose(goal, panda.base))
    down = user.hand[2, 3]
    user.until(lambda: user.hand[2, 3] < down - 0.02, "a twist of the hand", lambda: user.send_twist((0, 0, 0.1), panda.tip))
    assert panda.signed_distance(user.commands, world, self_collision=False).min() >= 0.009


def test_what_is_no_command_is_ignored(user, panda):
    user.until(lambda: user.status == "at rest", "a node that has started")

    def send():
        user.send_twist((0.1, 0, 0), "camera")
        user.send_twist((np.nan, 0, 0))
        user.send_pose(panda.forward_kinematics(panda.home + 0.1), "camera")

    for _ in range(20):
        send()
        user.listen(0.05)
    np.testing.assert_array_equal(user.q, panda.home)
    user.until(lambda: user.hand[1, 3] > 0.02, "a command after those", lambda: user.send_twist((0, 0.1, 0)))


def test_an_arm_that_begins_in_a_wall_is_said_to(machine, panda):
    world = ulna.World()
    world.add("wall", ulna.Box((0.3, 2, 2)), ulna.pose((0.5, 0, 0.5)))
    with node_of(panda, world) as node:
        node._beat()
        assert node._said.startswith("cannot start: q: not certainly free")
        world.remove("wall")
        node._beat()
        node._beat()
        assert node._said == "at rest"


def test_an_arm_off_its_command_begins_again_from_where_it_is(machine, panda):
    with node_of(panda, tracking_error=0.002) as node:
        node._beat()
        node._beat()
        node._measure(JointState(name=["panda_joint1"], position=[0.3]))  # the others are where they were
        node._beat()
        assert node._said == "off the command: panda_joint1"
        for _ in range(2):
            node._beat()
        assert node._said == "at rest"
        np.testing.assert_allclose(node._servo.q, [0.3, *panda.home[1:]])


def jog_of(joint, velocity):
    """A message as ``control_msgs/JointJog`` has it, whose package is not on the package index."""
    return SimpleNamespace(header=Header(), joint_names=[joint], velocities=[velocity])


def test_a_jog_moves_the_joints_that_it_names(machine, panda):
    with node_of(panda) as node:
        node._beat()
        for _ in range(50):
            node._take(node._jog, jog_of("panda_joint3", 0.2))
            node._beat()
        moved = node._servo.q - panda.home
        assert moved[2] == pytest.approx(0.2 * 0.48, abs=1e-2)
        np.testing.assert_allclose(np.delete(moved, 2), 0.0, atol=1e-9)


def test_a_limit_of_jerk_holds_from_tick_to_tick(machine, panda):
    fastest = {}
    for jerk in (None, 20.0):
        with node_of(panda, jerk=jerk) as node:
            node._beat()
            path = [node._servo.q]
            for _ in range(30):
                node._take(node._jog, jog_of("panda_joint3", 0.2))
                node._beat()
                path.append(node._servo.q)
        fastest[jerk] = np.abs(np.diff(path, 3, axis=0)).max() * 100**3
    assert fastest[20.0] <= 20.0 * (1 + 1e-6)
    assert fastest[None] > 100.0
