"""The demo as nodes of ROS 1: the arm with its light, and the box. Used by ``ros1_demo`` and hw2; only this imports rospy."""

# pyright: reportMissingImports=false

import signal
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
from ulna.demo.scenario import BOX_NAME, BOX_START, RATE_HZ, Demo
from ulna.description.pose import pose
from ulna.errors import InputError
from ulna.robot import Robot, load
from ulna.viewer.solid import Solid

_QUEUE = 30  # messages: a whole picture and more
_LOOK_FOR_MASTER_S = 1.0


class ArmAndLight:
    """Publishes where the arm stands and what it touches; hears where the box is."""

    def __init__(self, demo: Demo) -> None:
        self.robot = demo.robot
        self.player = Player(demo, self)
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=_QUEUE)
        self._markers = rospy.Publisher("visualization_marker", Marker, queue_size=_QUEUE)
        rospy.Subscriber(f"/{messages.SERVER}/feedback", InteractiveMarkerFeedback, self._hear, queue_size=1)
        rospy.Subscriber(f"/{messages.SERVER}/update_full", InteractiveMarkerInit, self._hear_all, queue_size=1)

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Tell the joints' positions."""
        self._joints.publish(_joint_state(self.robot, q))

    def draw_report(self, report: Report) -> None:
        """Tell the light, its word and the boxes."""
        for marker in messages.markers(self.robot, report):
            self._markers.publish(marker)

    def _hear_all(self, init: InteractiveMarkerInit) -> None:
        """A server tells its markers when it starts: then the box stands where it says."""
        for marker in init.markers:
            self._hear(InteractiveMarkerFeedback(header=marker.header, marker_name=marker.name, pose=marker.pose))

    def _hear(self, feedback: InteractiveMarkerFeedback) -> None:
        """Put the box where a marker is, whatever its name: the course's server calls it simple_6dof."""
        try:
            self.player.drag(messages.feedback_pose(feedback, self.robot.base))
        except InputError as error:
            rospy.logwarn_throttle(1.0, f"the box is at no valid pose, which is ignored: {error}")


class MovableBox:
    """The server of the box's handles."""

    def __init__(self, robot: Robot) -> None:
        self._base = robot.base
        self._last = messages.pose_message(pose(BOX_START))
        self._server = InteractiveMarkerServer(messages.SERVER)
        self._server.insert(messages.interactive_box(robot, pose(BOX_START)), self._dragged)
        self._server.applyChanges()

    def _dragged(self, feedback: InteractiveMarkerFeedback) -> None:
        """Tell the other screens; a place that is none is undone."""
        try:
            messages.feedback_pose(feedback, self._base)
            self._last = feedback.pose
        except InputError as error:
            rospy.logwarn_throttle(1.0, f"a place of the box that is none, undone: {error}")
            self._server.setPose(BOX_NAME, self._last)
        self._server.applyChanges()


@contextmanager
def node(name: str) -> Iterator[Callable[[], bool]]:
    """A node within a block; every node begins and ends here.

    Yields:
        Whether it shall end: SIGINT or SIGTERM has come, or ROS ends it. A second signal raises KeyboardInterrupt.
    """
    rospy.init_node(name, disable_signals=True)
    signals = _noted_signals()
    try:
        yield lambda: bool(signals) or rospy.is_shutdown()
    finally:
        rospy.signal_shutdown("the node ends")


def _noted_signals() -> list[int]:
    """The signals that will have come to end this program.

    rospy's own handler shuts the node down amid whatever the main thread does, and waits for ever for a lock that this thread
    holds, as in ``publish()``. This one takes no lock: the node ends between two steps.
    """
    come: list[int] = []

    def note(number: int, _frame: object) -> None:
        signal.signal(number, signal.default_int_handler)
        come.append(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)
    return come


def play_arm() -> None:
    """The arm repeats its trajectory, and the light answers the box, until the node is ended."""
    demo = Demo()
    with node("arm_and_light") as ended:
        beat(ArmAndLight(demo).player.advance, ended)


def hold_arm(q: NDArray[np.float64]) -> None:
    """The arm stands at q, shape (n_dof,), until the node is ended. No light: nothing is checked."""
    with node("arm") as ended:
        robot, publisher = load("panda"), rospy.Publisher("joint_states", JointState, queue_size=_QUEUE)
        beat(lambda _: publisher.publish(_joint_state(robot, q)), ended)


def _joint_state(robot: Robot, q: NDArray[np.float64]) -> JointState:
    """Where the joints are now."""
    message = messages.joint_state(robot, q)
    message.header.stamp = rospy.Time.now()
    return message


def show_solids(groups: Mapping[str, Sequence[Solid]]) -> None:
    """Show solids that stand still, by the namespaces in which RViz lists them, until the node is ended."""
    with node("collision_boxes") as ended:
        publisher = rospy.Publisher("visualization_marker", Marker, queue_size=_QUEUE)
        markers = [messages.solid_marker(solid, group, k) for group, solids in groups.items() for k, solid in enumerate(solids)]
        beat(lambda _: [publisher.publish(marker) for marker in markers], ended)


def serve_box() -> None:
    """Offer the box's handles until the node is ended."""
    with node("movable_box") as ended:
        _box = MovableBox(load("panda"))
        beat(lambda _: None, ended)


def beat(step: Callable[[float], object], ended: Callable[[], bool], found_master: Callable[[], object] = lambda: None) -> None:
    """Call ``step(seconds)`` at RATE_HZ, in real time, with the time gone by, until ``ended()``.

    A master that was lost is found again, and then ``found_master()`` is called, for the new one knows no parameters.
    """
    registration = Registration()
    last = time.monotonic()
    while not ended():
        now = time.monotonic()
        step(now - last)
        last = now
        with suppress(OSError):  # lost again at once: there will be a next one
            if registration.keep():
                found_master()
        time.sleep(max(0.0, 1.0 / RATE_HZ - (time.monotonic() - now)))


class Registration:
    """The node's entry with the master. A new master knows nothing of nodes from before its time: they must say it again."""

    def __init__(self) -> None:
        self._master = rosgraph.Master(rospy.get_name())
        self._pid = self._ask()
        self._asked = time.monotonic()

    def keep(self) -> bool:
        """Register again if the master is another one, and tell whether it is. Asks it once in a while."""
        if time.monotonic() - self._asked < _LOOK_FOR_MASTER_S:
            return False
        self._asked = time.monotonic()
        pid = self._ask()
        if pid is None:
            rospy.logwarn_throttle(30.0, "the master is lost; the demo goes on, and registers when there is one again")
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
        """Tell the master every topic of this node, and this node who publishes what it listens to."""
        uri, name = rospy.get_node_uri(), rospy.get_name()
        node: Any = ServerProxy(uri)
        for topic, kind in node.getPublications(name)[2]:
            self._master.registerPublisher(topic, kind, uri)
        for topic, kind in node.getSubscriptions(name)[2]:
            node.publisherUpdate(name, topic, self._master.registerSubscriber(topic, kind, uri))
        rospy.loginfo("registered with a new master")
