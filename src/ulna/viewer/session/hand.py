"""Moves an arm frame by frame so that its hand follows a drag, or gives the reason why it cannot."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Pair
from ulna.collision.world import World
from ulna.description.pose import rotation_vector_from_matrix
from ulna.description.robot_description import Joint, JointType, Limits
from ulna.ik.result import IKResult
from ulna.robot import Robot
from ulna.servo.command import CommandStatus
from ulna.servo.servo import Servo
from ulna.viewer.session.clearance import ShapeNames

MAX_A_FRAME = 0.25  # [rad or m] maximum change of a joint: faster than real arms, but too small for another IK branch
_STEPS, _DAMPING = 10, 0.03  # steps of differential inverse kinematics in a frame, and their damping
_MAX_ITERATIONS = 160  # iterations of inverse kinematics in a frame; on the same branch a few are enough
# The servo of a drag among obstacles. In a frame it accelerates for _TICKS ticks and then brakes: less than MAX_A_FRAME in all.
_RATE, _ACCELERATION, _TICKS = 500, 20.0, 50
_CLEARANCE, _MAX_NAMED_DISTANCE = 1e-3, 0.05  # [m] the clearance from obstacles, and the distance up to which a pair is named
_MIN_PROGRESS = 1e-9  # the minimum decrease of |displacement|^2 [m^2] + |rotation|^2 [rad^2] that counts as progress
BASES = (JointType.PLANAR, JointType.FLOATING)  # a mobile base does not move while its hand is dragged
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FollowResult:
    """The result of one frame.

    Attributes:
        q: Joint positions [rad or m], shape (n_dof,).
        reached: Whether the link is at the target.
        moving: Whether another frame would bring the link nearer to the target.
        reason: Why the target is not reached; see ``IKResult.reason``.
        stopped: Whether the reason is that the arm stopped before a collision.
    """

    q: Array
    reached: bool
    moving: bool
    reason: str = ""
    stopped: bool = False


class Hand:
    """A link that is dragged. Planar and floating joints do not move.

    Args:
        robot: The robot.
        link: The link's name; see ``robot.hand_link``.
        names: The shown names of the robot's shapes; made from the robot unless given.
    """

    def __init__(self, robot: Robot, link: str, names: ShapeNames | None = None) -> None:
        self.robot, self.link, self._names = robot, link, names or ShapeNames(robot)
        joints = robot.description.joints
        self.held = tuple(joint.name for joint in joints if joint.type in BASES and joint.name in robot.joint_names)
        unlimited = tuple(_without_velocity_limit(joint) for joint in joints)
        self._unlimited_robot = _with_limits_of(
            Robot(replace(robot.description, joints=unlimited, text=""), home=robot.home), robot
        )
        self._servo: Servo | None = None
        self._world: World | None = None  # the world of the servo

    def follow(self, q: Array, T: Array, world: World | None = None) -> FollowResult:
        """Move one frame towards a pose.

        1. Inverse kinematics searches on the IK branch of q: no joint moves by more than MAX_A_FRAME. Among obstacles, the edge
           to its solution is certified too.
        2. If that fails, differential inverse kinematics moves the arm nearer until no step decreases the error. Among obstacles
           a servo does this instead, and slides along them.

        Args:
            q: Joint positions [rad or m], shape (n_dof,).
            T: The pose to reach, T_base_link, shape (4, 4).
            world: Obstacles to avoid, together with self-collision. Collisions are not checked unless given.
        """
        found = self._search(q, T, world, max_iterations=_MAX_ITERATIONS)
        if found.success and self._is_free(q, found.q, world):
            return FollowResult(found.q, reached=True, moving=False)
        nearer, against = self._move_nearer(q, T, world)
        if self._miss(q, T) - self._miss(nearer, T) > _MIN_PROGRESS:
            return FollowResult(nearer, reached=False, moving=True)
        found = self._search(nearer, T, world)  # the arm makes no progress: find the reason
        if found.success and self._is_free(nearer, found.q, world):
            return FollowResult(found.q, reached=True, moving=False)
        if against:
            words = f"stopped before {self._names.list_pairs(against)} touch"
            return FollowResult(nearer, reached=False, moving=False, reason=words, stopped=True)
        return FollowResult(nearer, reached=False, moving=False, reason=_describe(found))

    def place(self, q: Array, T: Array, world: World | None = None) -> FollowResult:
        """Find a configuration at a pose on any IK branch, at any distance from q. For the arguments see ``follow``."""
        found = self.robot.inverse_kinematics(T, q, link=self.link, held=self.held, world=world)
        if found.success:
            return FollowResult(found.q, reached=True, moving=False)
        return FollowResult(q, reached=False, moving=False, reason=_describe(found))

    def _search(self, q: Array, T: Array, world: World | None, max_iterations: int | None = None) -> IKResult:
        return self.robot.inverse_kinematics(
            T, q, link=self.link, held=self.held, max_step=MAX_A_FRAME, world=world, max_iterations=max_iterations
        )

    def _is_free(self, q: Array, nearer: Array, world: World | None) -> bool:
        """Whether the edge between two configurations is certified; True if no obstacles are to be avoided."""
        return world is None or not self.robot.edge_in_collision(q, nearer, world)

    def _move_nearer(self, q: Array, T: Array, world: World | None) -> tuple[Array, tuple[Pair, ...]]:
        """Move the arm nearer in one frame. Returns its configuration, and the pair that limits the motion.

        An arm in contact may make any motion that decreases the penetration depth.
        """
        depth = inf if world is None else self.robot.signed_distance(q, world)
        if world is None or depth <= 0.0:
            nearer = self._step_differentially(q, T)
            if world is None or self.robot.signed_distance(nearer, world) > depth:
                return nearer, ()
        return self._steer(q, T, world)

    def _steer(self, q: Array, T: Array, world: World) -> tuple[Array, tuple[Pair, ...]]:
        """Move the arm towards the pose by a servo, for one frame. Returns as ``_move_nearer``."""
        if self._servo is None or self._world is not world:
            self._world, self._servo = world, self._servo_in(world)
        command = self._servo.start(np.clip(q, self.robot.lower, self.robot.upper), lead_out=True)
        for _ in range(_TICKS):
            command = self._servo.step(pose=T)
        limiting = command.limiting.pair
        while command.status is CommandStatus.BRAKING or command.qd.any():
            command = self._servo.step()
        if limiting is None:
            return command.q, ()
        pairs = self.robot.check_collision(command.q, world, max_distance=_MAX_NAMED_DISTANCE).pairs
        return command.q, tuple(pair for pair in pairs if (pair.name_a, pair.name_b) == limiting)

    def _servo_in(self, world: World) -> Servo:
        robot, allowed = self.robot, self.robot.allowed_collisions
        unlimited = Robot(self._unlimited_robot.description, home=robot.home, attached=robot.attached, allowed=allowed)
        return _with_limits_of(unlimited, robot).servo(
            world, link=self.link, held=self.held, rate=_RATE, acceleration=_ACCELERATION, clearance=_CLEARANCE
        )

    def _step_differentially(self, q: Array, T: Array) -> Array:
        """Move the arm towards the pose by differential inverse kinematics, for one frame."""
        miss = self._miss(q, T)
        for _ in range(_STEPS):
            change = self._unlimited_robot.differential_ik(q, self._error(q, T), 1.0, link=self.link, damping=_DAMPING)
            nearer = np.clip(q + _shortened(change), self.robot.lower, self.robot.upper)
            if (left := self._miss(nearer, T)) > miss - _MIN_PROGRESS / _STEPS:
                break
            q, miss = nearer, left
        return q

    def _error(self, q: Array, T: Array) -> Array:
        """The pose error at q: displacement [m] and rotation vector [rad] in the base, shape (6,)."""
        T_base_link = self.robot.forward_kinematics(q, link=self.link)
        return np.concatenate([T[:3, 3] - T_base_link[:3, 3], rotation_vector_from_matrix(T[:3, :3] @ T_base_link[:3, :3].T)])

    def _miss(self, q: Array, T: Array) -> float:
        error = self._error(q, T)
        return float(error @ error)


def _with_limits_of(unlimited: Robot, robot: Robot) -> Robot:
    """A robot with the position limits of another one, which may be narrower than those of its description."""
    narrowed = robot.tree.narrowed
    return unlimited if narrowed is None else unlimited.with_limits(lower=robot.lower, upper=robot.upper)


def _describe(found: IKResult) -> str:
    """The reason why inverse kinematics has not reached its target."""
    return f"{found.status}: {found.reason}" if found.reason else str(found.status)


def _shortened(change: Array) -> Array:
    """A step scaled down so that no joint moves by more than MAX_A_FRAME / _GLIDES."""
    return change * min(1.0, MAX_A_FRAME / _STEPS / max(float(np.abs(change).max()), 1e-12))


def _without_velocity_limit(joint: Joint) -> Joint:
    """A joint without a velocity limit, since some files give 0; with the limit 0 for a mobile base."""
    speed = 0.0 if joint.type in BASES else inf
    return replace(joint, limits=Limits(joint.limits.lower, joint.limits.upper, speed, joint.limits.effort))
