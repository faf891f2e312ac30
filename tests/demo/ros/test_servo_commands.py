"""What a servo is sent by ROS 2, read without ROS; and the node itself, with stand-ins for ROS's modules."""

import importlib
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import ulna
from ulna import InputError
from ulna.demo.ros.servo_commands import jog_goal, pose_goal, seconds_left, twist_goal
from ulna.demo.ros.servo_settings import Output, Settings
from ulna.servo.command import CommandStatus

NAN, INF = float("nan"), float("inf")


def fields(**values):
    return SimpleNamespace(**values)


def stamped(stamp=0.0, frame="", **body):
    seconds = int(stamp)
    return fields(header=fields(frame_id=frame, stamp=fields(sec=seconds, nanosec=int(1e9 * (stamp - seconds)))), **body)


def twist(v=0.0, w=0.0, **head):
    return stamped(twist=fields(linear=fields(x=v, y=0.0, z=0.0), angular=fields(x=w, y=0.0, z=0.0)), **head)


def posed(xyz=(0.4, 0.0, 0.4), xyzw=(0.0, 0.0, 0.0, 1.0), **head):
    position, orientation = dict(zip("xyz", xyz, strict=True)), dict(zip("xyzw", xyzw, strict=True))
    return stamped(pose=fields(position=fields(**position), orientation=fields(**orientation)), **head)


def jog(names, velocities, **head):
    return stamped(joint_names=names, velocities=velocities, **head)


@pytest.fixture(scope="module")
def on_a_table():
    """A hand on a joint, on a base that is turned on a table."""
    joints = '<joint name="mount" type="fixed"><parent link="table"/><child link="base"/><origin rpy="0 0 1.5"/></joint>'
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
    joints += f'<joint name="a" type="revolute"><parent link="base"/><child link="hand"/>{limit}</joint>'
    return ulna.load(f'<robot name="arm"><link name="table"/><link name="base"/><link name="hand"/>{joints}</robot>')


def test_a_twist_is_in_the_axes_of_its_frame(on_a_table):
    tree = on_a_table.tree
    assert twist_goal(twist(0.1), tree, "hand") == {"twist": [0.1, 0, 0, 0, 0, 0], "frame": "table"}
    assert twist_goal(twist(0.1, frame="base"), tree, "hand")["frame"] == "base"
    assert twist_goal(twist(0.1, frame="/hand"), tree, "hand") == {"twist": [0.1, 0, 0, 0, 0, 0], "expressed_in": "link"}
    with pytest.raises(InputError, match=r"frame_id: 'camera'; 'table' or 'base' or 'hand' is expected"):
        twist_goal(twist(0.1, frame="camera"), tree, "hand")


def test_a_pose_is_in_a_link_that_stands_still(on_a_table):
    assert pose_goal(posed(frame="/base"), on_a_table.tree)["frame"] == "base"
    with pytest.raises(InputError, match="frame_id: 'hand'"):
        pose_goal(posed(frame="hand"), on_a_table.tree)


@pytest.mark.parametrize("value", [NAN, INF, -INF])
def test_a_twist_that_is_not_finite_is_refused(value, on_a_table):
    with pytest.raises(InputError, match="finite"):
        twist_goal(twist(value), on_a_table.tree, "hand")


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (posed(xyzw=(0.0, 0.0, 0.0, 0.0)), "orientation: a quaternion of zeros"),
        (posed(xyzw=(NAN, 0.0, 0.0, 1.0)), "finite"),
        (posed(xyz=(INF, 0.0, 0.0)), "finite"),
        (posed(frame="camera"), "frame_id"),
    ],
)
def test_what_is_no_pose_is_refused(message, words, on_a_table):
    with pytest.raises(InputError, match=words):
        pose_goal(message, on_a_table.tree)


def test_a_pose_is_that_of_its_quaternion(on_a_table):
    T = pose_goal(posed(xyzw=(0.0, 0.0, 1.0, 0.0)), on_a_table.tree)["pose"]
    np.testing.assert_allclose(T, [[-1, 0, 0, 0.4], [0, -1, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1]], atol=1e-15)


@pytest.mark.parametrize(
    ("names", "velocities", "words"),
    [
        (["a"], [1.0], "'a' is not a joint of the arm, which has panda_joint1"),
        (["panda_joint1", "a"], [0.1, 1.0], "'a' is not a joint"),
        (["panda_finger_joint1"], [0.1], "not a joint of the arm"),
        ([], [], "joint_names: empty"),
        (["panda_joint1"] * 2, [0.1, 0.1], "panda_joint1"),
        (["panda_joint1"], [NAN], "panda_joint1|positions|finite"),
        (["panda_joint1"], [0.1, 0.2], "names|positions"),
    ],
)
def test_what_is_no_jog_of_this_arm_is_refused(panda, names, velocities, words):
    with pytest.raises(InputError, match=words):
        jog_goal(jog(names, velocities), panda)


def test_a_jog_moves_the_joints_that_it_names(panda):
    np.testing.assert_array_equal(jog_goal(jog(["panda_joint2"], [0.1]), panda)["velocity"], [0, 0.1, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(("age", "left"), [(0.0, 0.1), (0.04, 0.06), (-0.05, 0.1), (0.0999, 0.0001)])
def test_a_message_counts_from_its_stamp(age, left):
    assert seconds_left(stamped(1000.0 - age).header.stamp, 1000.0, 0.1) == pytest.approx(left, abs=1e-6)


@pytest.mark.parametrize("age", [0.11, 1.0, 999.0, -0.2, -1e6])
def test_a_message_of_another_time_is_refused(age):
    with pytest.raises(InputError, match=r"^stamp: .* (old|in the future); at most 0\.1 s is accepted"):
        seconds_left(stamped(1000.0 - age).header.stamp, 1000.0, 0.1)


def test_a_message_without_a_stamp_counts_from_its_arrival():
    assert seconds_left(stamped(0.0).header.stamp, 1e9, 0.1) == 0.1


class Node:
    """A node of rclpy that keeps what is published and what is read."""

    def __init__(self, _):
        self.out, self.subscribed = [], {}

    def create_publisher(self, _kind, topic, _queue):
        return fields(publish=lambda message: self.out.append((topic, message)))

    def create_subscription(self, _kind, topic, function, _queue):
        self.subscribed[topic] = function

    def create_timer(self, _period, function):
        self.beat = function

    def get_logger(self):
        return fields(warning=lambda words, **_: self.out.append(("warning", words)), info=lambda _: None)


class Steered:
    """A servo that keeps its goal in place of reaching it."""

    def __init__(self, robot):
        self.q, self.goal = robot.home, {}

    def step(self, measured=None, **goal):  # noqa: ARG002 - as a servo's
        self.goal = goal
        return fields(status=CommandStatus.AT_REST, q=self.q, qd=np.zeros(len(self.q)))


@pytest.fixture
def node(panda, monkeypatch):
    """The node of a Panda that is at home, and steered from there."""
    messages = {
        "geometry_msgs": ("PoseStamped", "TwistStamped"),
        "sensor_msgs": ("JointState",),
        "std_msgs": ("Float64MultiArray", "String"),
        "trajectory_msgs": ("JointTrajectory", "JointTrajectoryPoint"),
        "control_msgs": ("JointJog",),
    }
    names = {"rclpy": (), "rclpy.node": (), "rclpy.qos": ("QoSProfile",), "rclpy.signals": ("SignalHandlerOptions",)}
    names |= dict.fromkeys(messages, ()) | {f"{name}.msg": kinds for name, kinds in messages.items()}
    for name, kinds in names.items():
        module = ModuleType(name)
        vars(module).update({kind: type(kind, (SimpleNamespace,), {}) for kind in kinds})
        monkeypatch.setitem(sys.modules, name, module)
    sys.modules["rclpy.node"].Node = Node  # type: ignore[attr-defined]
    sys.modules["rclpy.qos"].DurabilityPolicy = fields(TRANSIENT_LOCAL=1)  # type: ignore[attr-defined]
    monkeypatch.delitem(sys.modules, "ulna.demo.ros.servo_node", raising=False)
    module = importlib.import_module("ulna.demo.ros.servo_node")
    monkeypatch.delitem(sys.modules, "ulna.demo.ros.servo_node")
    settings = Settings(panda.link_names[-1], 250.0, 5.0, None, 0.0, 0.0, Output.POSITIONS, None)
    made = module.ServoNode(panda, ulna.World(), settings, lambda *_: Steered(panda))
    made.now = lambda: 1000.0
    made.subscribed["/joint_states"](stamped(999.9, name=list(panda.joint_names), position=list(panda.home)))
    made.beat()
    return made


def moves(node):
    node.beat()
    return bool(node._servo.goal)


def test_a_node_moves_by_a_twist_of_now_and_not_by_one_of_long_ago(node):
    node.subscribed["~/delta_twist_cmds"](twist(0.05, stamp=1.0))
    assert not moves(node)
    assert any(topic == "warning" and "s old" in words for topic, words in node.out)
    node.subscribed["~/delta_twist_cmds"](twist(0.05, stamp=999.95))
    assert moves(node)


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("~/delta_joint_cmds", jog(["a"], [1.0])),
        ("~/pose_target_cmds", posed(xyzw=(0.0, 0.0, 0.0, 0.0))),
        ("~/delta_twist_cmds", twist(NAN)),
        ("~/delta_twist_cmds", twist(0.1, stamp=1.0)),
    ],
)
def test_what_is_no_command_does_not_replace_the_one_before(node, topic, message):
    node.subscribed["~/delta_twist_cmds"](twist(0.05))
    goal = node._goal
    node.subscribed[topic](message)
    assert node._goal is goal
    assert moves(node)


def test_a_measurement_of_long_ago_is_not_where_the_arm_is(node, panda):
    before = node._q.copy()
    node.subscribed["/joint_states"](stamped(900.0, name=list(panda.joint_names), position=[0.0, 0, 0, -1, 0, 1, 0]))
    np.testing.assert_array_equal(node._q, before)
