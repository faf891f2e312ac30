"""Reads servo commands of ROS 2, without importing ROS: goals of twists, poses and joint velocities, and their age."""

from typing import Any

import numpy as np

from ulna.description.pose import pose
from ulna.errors import InputError, cited
from ulna.kinematics.frames import standing_links
from ulna.kinematics.tree import Tree
from ulna.robot import Robot

Goal = dict[str, Any]
"""The keyword arguments of ``Servo.step``."""


def twist_goal(message: Any, tree: Tree, link: str) -> Goal:
    """Read a ``TwistStamped`` [m/s and rad/s] along the axes of its frame: the steered link, or a fixed one.

    Raises:
        InputError: It is in another frame, or not finite.
    """
    v, w = message.twist.linear, message.twist.angular
    twist = [v.x, v.y, v.z, w.x, w.y, w.z]
    frame = _frame(message, tree, link)
    if not np.isfinite(twist).all():
        raise InputError("twist", f"{cited(twist)}; finite numbers are expected")
    return {"twist": twist, "expressed_in": "link"} if frame == link else {"twist": twist, "frame": frame}


def pose_goal(message: Any, tree: Tree) -> Goal:
    """Read a ``PoseStamped``, whose frame is a fixed link.

    Raises:
        InputError: It is in another frame, not finite, or without an orientation: a quaternion of zeros was not set.
    """
    frame = _frame(message, tree)
    p, r = message.pose.position, message.pose.orientation
    xyz, wxyz = (p.x, p.y, p.z), (r.w, r.x, r.y, r.z)
    if not np.isfinite((*xyz, *wxyz)).all():
        raise InputError("pose", f"{cited((*xyz, *wxyz))}; finite numbers are expected")
    if not any(wxyz):
        raise InputError("orientation", "a quaternion of zeros; no rotation is x, y, z, w = 0, 0, 0, 1")
    return {"pose": pose(xyz, wxyz=wxyz), "frame": frame}


def jog_goal(message: Any, robot: Robot) -> Goal:
    """Read joint velocities of a ``control_msgs/JointJog``; unnamed joints stay.

    Raises:
        InputError: It names no joint, an unknown joint, or a joint twice; or its velocities are not one finite number for each.
    """
    names = list(message.joint_names)
    unknown = [name for name in names if name not in robot.joint_names]
    if unknown or not names:
        has = ", ".join(robot.joint_names)
        raise InputError("joint_names", f"{cited(unknown[0])} is not a joint of the arm, which has {has}" if unknown else "empty")
    return {"velocity": robot.q_of_joints(names, message.velocities, others=np.zeros(robot.n_dof))}


def seconds_left(stamp: Any, now: float, timeout: float) -> float:
    """The remaining validity of a message [s], 0 to ``timeout``; all of it for an unset stamp of 0.

    Args:
        stamp: The stamp of its header, with ``sec`` and ``nanosec``.
        now: The time by the same clock [s].
        timeout: Its validity from the stamp on [s].

    Raises:
        InputError: It is older than that, or its stamp is as far in the future: the clocks differ.
    """
    sent = float(getattr(stamp, "sec", 0)) + 1e-9 * float(getattr(stamp, "nanosec", 0))
    if sent == 0.0:
        return timeout
    age = now - sent
    if not -timeout <= age < timeout:
        words = f"{age:.3g} s old" if age > 0 else f"{-age:.3g} s in the future"
        raise InputError("stamp", f"{words}; at most {timeout:g} s is accepted: do the clocks of sender and node agree?")
    return min(timeout, timeout - age)


def _frame(message: Any, tree: Tree, *others: str) -> str:
    """The frame of a message: a fixed link, the base if it names none, or one of the others."""
    frame, known = message.header.frame_id.removeprefix("/") or tree.root, (*standing_links(tree), *others)
    if frame not in known:
        raise InputError("frame_id", f"{cited(frame)}; {' or '.join(map(repr, known))} is expected")
    return frame
