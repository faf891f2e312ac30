"""Runs a servo as one node of ROS 2, with MoveIt Servo's topics for twists, poses and joint velocities.

Source of the names: moveit_servo, the node ``servo_node``: ``~/delta_twist_cmds``, ``~/pose_target_cmds``, ``~/delta_joint_cmds``
and ``~/status``. A command is valid for 0.1 s from its stamp, as with its parameter ``incoming_command_timeout``.
"""

# pyright: reportMissingImports=false

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ulna.collision.world import World
from ulna.demo.ros.adapter import noted_signals
from ulna.demo.ros.servo_commands import Goal, jog_goal, pose_goal, seconds_left, twist_goal
from ulna.demo.ros.servo_settings import Output, Settings
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.servo.command import Command, CommandStatus
from ulna.servo.servo import Servo

try:
    from control_msgs.msg import JointJog
except ModuleNotFoundError:  # it has no wheel: it comes with a system installation of ROS 2
    JointJog = None
_TIMEOUT = 0.1  # [s], validity of a command, from its stamp if it has one
_STATE_TIMEOUT = 1.0  # [s], validity of a measurement
_QUEUE = 10  # messages
_SECONDS = 1.0  # [s], between two warnings of one kind


# The types of the output messages, and the default topics of the controllers of ros2_controllers.
_OUTPUTS = {
    Output.TRAJECTORY: (JointTrajectory, "/joint_trajectory_controller/joint_trajectory"),
    Output.POSITIONS: (Float64MultiArray, "/forward_position_controller/commands"),
}


class ServoNode(Node):
    """Steers from the position in ``/joint_states`` by the newest command that is still valid.

    Args:
        robot: The arm; each joint has one entry of q.
        world: The objects, if any.
        settings: Rates, limits and topics.
        ask: Calls functions, by ``Compiler.ask``.

    Attributes:
        now: The time by the clock of the messages' stamps [s]; ``steer`` sets the clock of ROS, which may be simulated.
    """

    now: Callable[[], float] = staticmethod(time.time)

    def __init__(self, robot: Robot, world: World | None, settings: Settings, ask: Callable[..., Any]) -> None:
        super().__init__("servo_node")
        self._robot, self._settings, self._made_of, self._ask = robot, settings, (robot, world, settings), ask
        self._servo: Servo | None = None
        self._q: NDArray[np.float64] | None = None  # as measured
        self._goal: Goal = {}
        self._until = 0.0  # end of the goal's validity [s]
        self._said, self._moved = "", False
        kind, topic = _OUTPUTS[settings.output]
        self._commands = self.create_publisher(kind, settings.topic or topic, _QUEUE)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # a later subscriber receives it too
        self._status = self.create_publisher(String, "~/status", kept)
        self.create_subscription(JointState, "/joint_states", self._measure, _QUEUE)
        self.create_subscription(TwistStamped, "~/delta_twist_cmds", lambda message: self._take(self._twist, message), _QUEUE)
        self.create_subscription(PoseStamped, "~/pose_target_cmds", lambda message: self._take(self._pose, message), _QUEUE)
        if JointJog is not None:
            self.create_subscription(JointJog, "~/delta_joint_cmds", lambda message: self._take(self._jog, message), _QUEUE)
        else:
            self.get_logger().warning("the module control_msgs is missing, so ~/delta_joint_cmds is not read")
        self.create_timer(1.0 / settings.rate, self._beat)

    def _twist(self, message: TwistStamped) -> Goal:
        return twist_goal(message, self._robot.tree, self._settings.link)

    def _pose(self, message: PoseStamped) -> Goal:
        return pose_goal(message, self._robot.tree)

    def _jog(self, message: Any) -> Goal:
        return jog_goal(message, self._robot)

    def _take(self, goal_of: Callable[[Any], Goal], message: Any) -> None:
        """Accept a command; an invalid or outdated one is ignored, and the one before stays valid to its own end."""
        try:
            left = seconds_left(message.header.stamp, self.now(), _TIMEOUT)
            self._goal, self._until = goal_of(message), time.monotonic() + left
        except InputError as error:
            self._warn(f"ignored an invalid command: {error}")

    def _measure(self, message: JointState) -> None:
        try:
            seconds_left(message.header.stamp, self.now(), _STATE_TIMEOUT)
            self._q = self._robot.q_of_joints(message.name, message.position, others=self._q)
        except InputError as error:
            self._warn(f"ignored an invalid joint state: {error}")

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text, throttle_duration_sec=_SECONDS)

    def _beat(self) -> None:
        """Run one tick, once the arm's position is known and the kernels are compiled."""
        if self._servo is None:
            self._servo = None if self._q is None else self._begun(self._q)
            return
        command = self._step(self._servo)
        moved, self._moved = self._moved, command.status is not CommandStatus.AT_REST
        if moved or self._moved:  # at rest one message suffices
            self._commands.publish(self._message(command))
        self._say(str(command))
        if command.status is CommandStatus.OFF_COMMAND and not command.qd.any():
            self._servo = None  # start again from the measured position

    def _begun(self, q: NDArray[np.float64]) -> Servo | None:
        """A servo at rest at q; None while its kernels are compiled, or if it cannot start."""
        try:
            return self._ask("the servo", _started, *self._made_of, q)
        except InputError as error:
            self._say(f"cannot start: {error}")
            return None

    def _step(self, servo: Servo) -> Command:
        measured = self._q if self._settings.tracking_error > 0.0 else None
        goal = self._goal if time.monotonic() < self._until else {}
        try:
            return servo.step(**goal, measured=measured)
        except InputError as error:
            self._warn(f"ignored an invalid command: {error}")
            self._goal = {}
            return servo.step(measured=measured)

    def _say(self, sentence: str) -> None:
        if sentence != self._said:
            self._said = sentence
            self._status.publish(String(data=sentence))

    def _message(self, command: Command) -> JointTrajectory | Float64MultiArray:
        q = command.q.tolist()
        if self._settings.output is Output.POSITIONS:
            return Float64MultiArray(data=q)
        point = JointTrajectoryPoint(positions=q, velocities=command.qd.tolist(), accelerations=command.qdd.tolist())
        point.time_from_start.nanosec = round(1e9 / self._settings.rate)
        return JointTrajectory(joint_names=list(self._robot.joint_names), points=[point])


def _made(robot: Robot, world: World | None, settings: Settings) -> Servo:
    given = settings._asdict()
    del given["output"], given["topic"]
    return robot.servo(world, **given)


def _started(robot: Robot, world: World | None, settings: Settings, q: NDArray[np.float64]) -> Servo:
    servo = _made(robot, world, settings)
    servo.start(q)
    return servo


def steer(robot: Robot, world: World | None, settings: Settings, ask: Callable[..., Any]) -> None:
    """Run the node until Ctrl-C or SIGTERM; ``ask`` is ``Compiler.ask``.

    Raises:
        InputError: A joint has several entries of q, which no message supports; or a setting is invalid.
        GeometryError: The robot has no shapes that can be checked.
    """
    if len(robot.joint_names) != robot.n_dof:
        raise InputError("robot", "it has a planar or a floating joint, which the messages of controllers do not support")
    _made(robot, world, settings)  # raises errors here rather than in the node
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signals = noted_signals()
    try:
        node = ServoNode(robot, world, settings, ask)
        node.now = lambda: 1e-9 * node.get_clock().now().nanoseconds
        node.get_logger().info("the servo waits for /joint_states; Ctrl-C ends it")
        while not signals:
            rclpy.spin_once(node)  # returns at the next timer tick at the latest
    finally:
        rclpy.try_shutdown()
