"""Runs the demo as nodes of ROS 1: the arm with its light, and the box."""

# pyright: reportMissingImports=false

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit, Marker

from ulna.collision.report import Report
from ulna.demo.player import Player
from ulna.demo.ros import messages
from ulna.demo.ros.adapter import node_compiler, noted_signals
from ulna.demo.scenario import BOX_NAME, BOX_START, RATE_HZ, Demo
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.errors import InputError
from ulna.robot import Robot, load
from ulna.viewer.palette import Solid

_QUEUE = 30  # messages: more than the markers of one picture
_LOOK_FOR_MASTER_S = 1.0


class ArmAndLight:
    """Publishes the joints and the contacts of the arm; subscribes to the pose of the box."""

    def __init__(self, demo: Demo, ask: Callable[..., Any]) -> None:
        self.robot = demo.robot
        self.player = Player(demo, self, ask)
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=_QUEUE)
        self._markers = rospy.Publisher("visualization_marker", Marker, queue_size=_QUEUE)
        rospy.Subscriber(f"/{messages.SERVER}/feedback", InteractiveMarkerFeedback, self._hear, queue_size=1)
        rospy.Subscriber(f"/{messages.SERVER}/update_full", InteractiveMarkerInit, self._hear_all, queue_size=1)

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Publish the joint positions."""
        self._joints.publish(messages.joint_state(self.robot, q, rospy.Time.now()))

    def draw_report(self, report: Report | None) -> None:
        """Publish the light, its text and the boxes; the light is gray while the report is unknown."""
        for marker in messages.markers(self.robot, report):
            self._markers.publish(marker)

    def _hear_all(self, init: InteractiveMarkerInit) -> None:
        """Move the box to the pose that a marker server publishes at its start."""
        for marker in init.markers:
            self._hear(InteractiveMarkerFeedback(header=marker.header, marker_name=marker.name, pose=marker.pose))

    def _hear(self, feedback: InteractiveMarkerFeedback) -> None:
        """Move the box to the pose of a marker of any name: the course's server calls it simple_6dof."""
        try:
            self.player.drag(messages.feedback_pose(feedback, self.robot.base))
        except InputError as error:
            rospy.logwarn_throttle(1.0, f"ignored an invalid pose of the box: {error}")


class MovableBox:
    """The server of the box's handles."""

    def __init__(self, robot: Robot) -> None:
        self._base = robot.base
        self._last = messages.pose_message(pose(BOX_START))
        self._server = InteractiveMarkerServer(messages.SERVER)
        self._server.insert(messages.interactive_box(robot, pose(BOX_START)), self._dragged)
        self._server.applyChanges()

    def _dragged(self, feedback: InteractiveMarkerFeedback) -> None:
        """Publish the new pose to other RViz windows; an invalid pose is undone."""
        try:
            messages.feedback_pose(feedback, self._base)
            self._last = feedback.pose
        except InputError as error:
            rospy.logwarn_throttle(1.0, f"undid an invalid pose of the box: {error}")
            self._server.setPose(BOX_NAME, self._last)
        self._server.applyChanges()


@contextmanager
def node(name: str) -> Iterator[Callable[[], bool]]:
    """A context that starts and ends a node.

    Yields:
        A function that returns whether the node is to end: after SIGINT or SIGTERM, or if ROS ends it. A second signal raises
            SystemExit.
    """
    rospy.init_node(name, disable_signals=True)
    signals = noted_signals()
    try:
        yield lambda: bool(signals) or rospy.is_shutdown()
    finally:
        rospy.signal_shutdown("the node ends")


def play_arm() -> None:
    """Play the arm's trajectory, and update the light when the box moves, until the node is ended."""
    with node_compiler() as compiler, node("arm_and_light") as ended:
        beat(ArmAndLight(Demo(), compiler.ask).player.advance, ended)


def hold_arm(q: NDArray[np.float64]) -> None:
    """Publish the arm at q, shape (n_dof,), until the node is ended. There is no collision check, and no light."""
    with node("arm") as ended:
        robot, publisher = load("panda"), rospy.Publisher("joint_states", JointState, queue_size=_QUEUE)
        beat(lambda _: publisher.publish(messages.joint_state(robot, q, rospy.Time.now())), ended)


def show_boxes(make: Callable[[], Mapping[str, Sequence[Solid[Box]]]]) -> None:
    """Publish static boxes, in the namespaces that RViz lists, and a legend, until the node is ended."""
    with node_compiler() as compiler, node("collision_boxes") as ended:
        publisher = rospy.Publisher("visualization_marker", Marker, queue_size=_QUEUE)

        def publish(_seconds: float) -> None:
            groups = compiler.ask("their poses", make) or {}
            for marker in (*messages.edged_boxes(groups), *messages.legend(groups)):
                publisher.publish(marker)

        beat(publish, ended)


def serve_box() -> None:
    """Offer the box's handles until the node is ended."""
    with node("movable_box") as ended:
        _box = MovableBox(load("panda"))
        beat(lambda _: None, ended)


def beat(step: Callable[[float], object], ended: Callable[[], bool], found_master: Callable[[], object] = lambda: None) -> None:
    """Call ``step(seconds)`` at RATE_HZ with the elapsed time, until ``ended()``.

    If another master has started, the node registers with it and calls ``found_master()``, since the new master has no
    parameters.
    """
    registration = Registration()
    last = time.monotonic()
    while not ended():
        now = time.monotonic()
        step(now - last)
        last = now
        with suppress(OSError):  # the master is lost again; the next call tries again
            if registration.keep():
                found_master()
        time.sleep(max(0.0, 1.0 / RATE_HZ - (time.monotonic() - now)))


class Registration:
    """The node's registration with the master; renewed after a restart of the master, which has lost it."""

    def __init__(self) -> None:
        self._master = rosgraph.Master(rospy.get_name())
        self._pid = self._ask()
        self._asked = time.monotonic()

    def keep(self) -> bool:
        """Register again if another master has started. Returns whether one has. Checks once per _LOOK_FOR_MASTER_S."""
        if time.monotonic() - self._asked < _LOOK_FOR_MASTER_S:
            return False
        self._asked = time.monotonic()
        pid = self._ask()
        if pid is None:
            rospy.logwarn_throttle(30.0, "the master is lost; the demo continues, and registers with the next master")
        elif pid != self._pid:
            self._register()
            self._pid = pid
            return True
        return False

    def _ask(self) -> int | None:
        try:
            return self._master.getPid()
        except (OSError, rosgraph.MasterException):
            return None

    def _register(self) -> None:
        """Register every topic of this node with the master, and connect it to the publishers of its subscriptions."""
        uri, name = rospy.get_node_uri(), rospy.get_name()
        node: Any = ServerProxy(uri)
        for topic, kind in node.getPublications(name)[2]:
            self._master.registerPublisher(topic, kind, uri)
        for topic, kind in node.getSubscriptions(name)[2]:
            node.publisherUpdate(name, topic, self._master.registerSubscriber(topic, kind, uri))
        rospy.loginfo("registered with a new master")
