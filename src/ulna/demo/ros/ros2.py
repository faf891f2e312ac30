"""Runs the demo as one node of ROS 2: joints, tf, the description, the light, the box."""

# pyright: reportMissingImports=false

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerPose, InteractiveMarkerUpdate, MarkerArray
from visualization_msgs.srv import GetInteractiveMarkers

from ulna.collision.report import Report
from ulna.demo.player import Player
from ulna.demo.ros import messages
from ulna.demo.ros.adapter import noted_signals
from ulna.demo.ros.description import robot_description
from ulna.demo.scenario import BOX_NAME, RATE_HZ, Demo
from ulna.errors import InputError
from ulna.robot import Robot, load

try:
    from tf2_msgs.msg import TFMessage
except ModuleNotFoundError:  # it has no wheel: it comes with a system installation of ROS 2
    TFMessage = None
NO_TF = "the module tf2_msgs is missing, so nothing is published on /tf; use the Python of a full ROS 2 to see the arm in RViz 2"
_QUEUE = 30  # messages


class DemoNode(Node):
    """Publishes the joints, the light and the boxes, offers the handles of the box, and follows a drag."""

    def __init__(self, demo: Demo, ask: Callable[..., Any]) -> None:
        super().__init__("ulna_demo")
        self.demo = demo
        self.player = Player(demo, self, ask)
        self._joints = self.create_publisher(JointState, "joint_states", _QUEUE)
        self._markers = self.create_publisher(MarkerArray, "visualization_marker_array", _QUEUE)
        self._tf = None
        if TFMessage is not None:
            self._tf = self.create_publisher(TFMessage, "/tf", _QUEUE)
        else:
            self.get_logger().warning(NO_TF)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # an RViz that starts later receives it too
        self._description = self.create_publisher(String, "robot_description", kept)
        text = robot_description(demo.robot, self.get_logger().warning)
        self._description.publish(String(data=text))
        self._described, self._ask = load(text), ask
        self._handles = Handles(self, self._put_box)
        self._last = time.monotonic()
        self.create_timer(1.0 / RATE_HZ, self._beat)

    def draw_arm(self, q: NDArray[np.float64]) -> None:
        """Publish the joint positions and the pose of each link."""
        stamp = self.get_clock().now().to_msg()
        message = messages.joint_state(self.demo.robot, q, stamp)
        self._joints.publish(message)
        if self._tf is not None and TFMessage is not None:
            q = self._described.q_of_joints(message.name, message.position)
            poses = self._ask("the poses of the links", self._described.link_poses, q)
            if poses is not None:
                self._tf.publish(TFMessage(transforms=transforms(self._described, poses, stamp)))

    def draw_report(self, report: Report | None) -> None:
        """Publish the light, its text and the boxes; the light is gray while the report is unknown."""
        self._markers.publish(MarkerArray(markers=list(messages.markers(self.demo.robot, report))))

    def _beat(self) -> None:
        now = time.monotonic()
        self.player.advance(now - self._last)
        self._last = now

    def _put_box(self, feedback: InteractiveMarkerFeedback) -> None:
        """Move the box to the pose of a marker of any name, as the node of ROS 1 does."""
        try:
            self.player.drag(messages.feedback_pose(feedback, self.demo.robot.base))
        except InputError as error:
            self.get_logger().warning(f"undid an invalid pose of the box: {error}", throttle_duration_sec=1.0)
        self._handles.tell()


class Handles:
    """The topics and the service of an interactive-marker server for RViz 2, without the package ``interactive_markers``."""

    def __init__(self, node: DemoNode, heard: Callable[[InteractiveMarkerFeedback], None]) -> None:
        self._demo, self._number = node.demo, 0
        self._updates = node.create_publisher(InteractiveMarkerUpdate, f"{messages.SERVER}/update", _QUEUE)
        node.create_service(GetInteractiveMarkers, f"{messages.SERVER}/get_interactive_markers", self._answer)
        node.create_subscription(InteractiveMarkerFeedback, f"{messages.SERVER}/feedback", heard, _QUEUE)

    def tell(self) -> None:
        """Publish the pose of the box."""
        box = messages.interactive_box(self._demo.robot, self._demo.world.pose(BOX_NAME))
        self._number += 1
        place = InteractiveMarkerPose(header=box.header, pose=box.pose, name=box.name)
        self._updates.publish(InteractiveMarkerUpdate(seq_num=self._number, type=InteractiveMarkerUpdate.UPDATE, poses=[place]))

    def _answer(self, _request: GetInteractiveMarkers.Request, response: GetInteractiveMarkers.Response):
        response.sequence_number = self._number
        response.markers = [messages.interactive_box(self._demo.robot, self._demo.world.pose(BOX_NAME))]
        return response


def transforms(robot: Robot, poses: NDArray[np.float64], stamp) -> list[TransformStamped]:
    """The pose of each link except the root in the base, from ``link_poses``, shape (n_links, 4, 4)."""
    found = []
    for name, T in zip(robot.link_names, poses, strict=True):
        if name != robot.base:
            place = messages.pose_message(T)
            p = place.position
            tf = TransformStamped(child_frame_id=name)
            tf.header.stamp, tf.header.frame_id = stamp, robot.base
            tf.transform = Transform(translation=Vector3(x=p.x, y=p.y, z=p.z), rotation=place.orientation)
            found.append(tf)
    return found


def play(demo: Demo, ask: Callable[..., Any]) -> None:
    """Run the node until Ctrl-C or SIGTERM; ``ask`` is ``Compiler.ask``."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signals = noted_signals()
    try:
        node = DemoNode(demo, ask)
        node.get_logger().info("the demo runs; Ctrl-C ends it")
        while not signals:
            rclpy.spin_once(node)  # returns at the next timer tick at the latest
    finally:
        rclpy.try_shutdown()
