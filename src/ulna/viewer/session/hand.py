"""Moves an arm so that its hand follows a drag, frame by frame, or gives the reason why not."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Pair
from ulna.collision.world import World
from ulna.description.pose import quaternion_from_matrix
from ulna.description.robot_description import Joint, JointType, Limits
from ulna.ik.result import IKResult
from ulna.robot import Robot
from ulna.viewer.session.clearance import ShapeNames
from ulna.viewer.session.sliding import along_contacts

MOST_A_FRAME = 0.25  # [rad or m] the largest change of a joint: faster than real arms, but too small for another IK branch
_GLIDES, _DAMPING = 10, 0.03  # steps of differential inverse kinematics in a frame, and their damping
_QUICK = 160  # steps of the search in a frame: if the branch continues, a few are enough
_AT_REST = 1e-9  # the least decrease of |displacement|^2 [m^2] + |rotation|^2 [rad^2] that counts as progress
BASES = (JointType.PLANAR, JointType.FLOATING)  # a mobile base does not move while its hand is dragged
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Followed:
    """The result of one frame.

    Attributes:
        q: Joint positions [rad or m], shape (n_dof,).
        reached: Whether the link is at the target.
        moving: Whether another frame would bring it nearer.
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
        unhurried = tuple(_unhurried(joint) for joint in joints)
        self._loop = Robot(replace(robot.description, joints=unhurried, text=""), home=robot.home)

    def follow(self, q: Array, T: Array, world: World | None = None) -> Followed:
        """One frame towards a pose.

        The search stays on the IK branch of q: no joint moves by more than MOST_A_FRAME. If it does not reach the pose,
        differential inverse kinematics moves the arm nearer, until no step does; along obstacles, if these are to be avoided.

        Args:
            q: Joint positions [rad or m], shape (n_dof,).
            T: The pose to reach, T_base_link, shape (4, 4).
            world: Obstacles to avoid; then self-collision is avoided too. Collisions are not checked unless given.
        """
        found = self._search(q, T, world, max_iterations=_QUICK)
        if found.success:
            return Followed(found.q, reached=True, moving=False)
        nearer, against = self._glide(q, T, world)
        if self._miss(q, T) - self._miss(nearer, T) > _AT_REST:
            return Followed(nearer, reached=False, moving=True)
        found = self._search(nearer, T, world)  # the arm has stopped: find the reason
        if found.success:
            return Followed(found.q, reached=True, moving=False)
        if against:
            words = f"stopped before {self._names.listed(against)} touch"
            return Followed(nearer, reached=False, moving=False, reason=words, stopped=True)
        return Followed(nearer, reached=False, moving=False, reason=_words(found))

    def place(self, q: Array, T: Array, world: World | None = None) -> Followed:
        """A configuration at a pose, on any IK branch, however far it is from q. Arguments as ``follow``."""
        found = self.robot.inverse_kinematics(T, q, link=self.link, held=self.held, world=world)
        if found.success:
            return Followed(found.q, reached=True, moving=False)
        return Followed(q, reached=False, moving=False, reason=_words(found))

    def _search(self, q: Array, T: Array, world: World | None, max_iterations: int | None = None) -> IKResult:
        return self.robot.inverse_kinematics(
            T, q, link=self.link, held=self.held, max_step=MOST_A_FRAME, world=world, max_iterations=max_iterations
        )

    def _glide(self, q: Array, T: Array, world: World | None) -> tuple[Array, tuple[Pair, ...]]:
        """The nearest configuration to the pose that one frame reaches, and the pairs that prevent a nearer one."""
        miss, against = self._miss(q, T), ()
        for _ in range(_GLIDES):
            change = self._loop.differential_ik(q, self._error(q, T), 1.0, link=self.link, damping=_DAMPING)
            if world is not None:
                change, against = self._kept_off(q, _shortened(change), world)
            nearer = np.clip(q + _shortened(change), self.robot.lower, self.robot.upper)
            if (left := self._miss(nearer, T)) > miss - _AT_REST / _GLIDES:
                break
            q, miss = nearer, left
        return q, against

    def _error(self, q: Array, T: Array) -> Array:
        """The remaining displacement [m] and rotation vector [rad], in the axes of the base, shape (6,)."""
        T_base_link = self.robot.forward_kinematics(q, link=self.link)
        return np.concatenate([T[:3, 3] - T_base_link[:3, 3], rotation_vector(T[:3, :3] @ T_base_link[:3, :3].T)])

    def _miss(self, q: Array, T: Array) -> float:
        error = self._error(q, T)
        return float(error @ error)

    def _kept_off(self, q: Array, change: Array, world: World) -> tuple[Array, tuple[Pair, ...]]:
        """A step without collision near a wanted one, and the pairs that have changed it; a zero step if there is none."""
        slid, against = along_contacts(self.robot, q, change, self.link, world)
        for part in (1.0, 0.25):
            step = part * slid
            nearer = np.clip(q + _shortened(step), self.robot.lower, self.robot.upper)
            if self._may_go(q, nearer, world):
                return step, against
        hits = tuple(pair for pair in self.robot.check_collision(nearer, world).pairs if pair.signed_distance <= 0.0)
        return np.zeros_like(change), against or hits

    def _may_go(self, q: Array, nearer: Array, world: World) -> bool:
        """Whether a step ends free of collision, or less deep in a collision than it began."""
        after = self.robot.signed_distance(nearer, world)
        return after > 0.0 or after > self.robot.signed_distance(q, world)


def _words(found: IKResult) -> str:
    """Why a search has not reached its target."""
    return f"{found.status}: {found.reason}" if found.reason else str(found.status)


def _shortened(change: Array) -> Array:
    """A step scaled down so that no joint moves by more than MOST_A_FRAME / _GLIDES."""
    return change * min(1.0, MOST_A_FRAME / _GLIDES / max(float(np.abs(change).max()), 1e-12))


def rotation_vector(R: Array) -> Array:
    """The axis of a rotation times its angle [rad], shape (3,); for half a turn, one of the two possible axes."""
    w, *xyz = quaternion_from_matrix(R)
    sine = float(np.linalg.norm(xyz))
    return np.array(xyz) * (2.0 if sine < 1e-12 else 2.0 * np.arctan2(sine, w) / sine)


def _unhurried(joint: Joint) -> Joint:
    """A joint without a velocity limit, since some files give 0; with the limit 0 if the joint is not to move."""
    speed = 0.0 if joint.type in BASES else inf
    return replace(joint, limits=Limits(joint.limits.lower, joint.limits.upper, speed, joint.limits.effort))
