"""Compares a robot's description with the arm that is connected."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.arms.arm_model import FR3
from ulna.description.pose import inverse
from ulna.errors import InputError
from ulna.robot import Robot

Array = NDArray[np.float64]
_NEAR = 1e-3  # [m], and of a rotation matrix: of a description's last axis from the measured one
_ROUNDED = 1e-6  # [rad], of the limits in a description


def refuse_another_robot(robot: Robot, q: ArrayLike, T_base_flange: Array) -> None:
    """Refuse a description that is not a Franka Research 3's.

    How far the flange is along the axis of the last joint is not compared: a simulator measures the frame of that joint for it.

    Args:
        robot: The description, loaded.
        q: Where the arm is measured, shape (7,) [rad].
        T_base_flange: Where it says that its flange is then, shape (4, 4).

    Raises:
        InputError: It has other joints or wider limits, or the axis of its last joint is elsewhere than measured.
    """
    moving = [joint for joint in robot.description.joints if joint.name in robot.joint_names]
    if robot.n_dof != FR3.n_dof or any(joint.type not in {"revolute", "continuous"} for joint in moving):
        raise InputError("robot", f"{robot.name} has {robot.n_dof} entries of q, and a {FR3.name} has 7 joints that turn")
    wide = [
        name
        for name, low, high, least, most in zip(robot.joint_names, robot.lower, robot.upper, FR3.lower, FR3.upper, strict=True)
        if low < least - _ROUNDED or high > most + _ROUNDED
    ]
    if wide:
        raise InputError("robot", f"{robot.name} lets {', '.join(wide)} go beyond the limits of a {FR3.name}")
    last = next(joint for joint in moving if joint.name == robot.joint_names[-1])
    first = next(joint for joint in moving if joint.name == robot.joint_names[0])
    T_first, T_last = (robot.forward_kinematics(np.array(q), link=link) for link in (first.parent, last.child))
    described = inverse(T_first) @ T_last
    moved, turned = described[:3, 3] - T_base_flange[:3, 3], np.abs(described[:3, :3] - T_base_flange[:3, :3]).max()
    beside = np.linalg.norm(moved - described[:3, 2] * (described[:3, 2] @ moved))
    if not max(beside, turned) <= _NEAR:
        raise InputError(
            "robot",
            f"{robot.name} has the axis of its last joint {beside * 1e3:.1f} mm beside where the arm measures it, and a rotation "
            f"matrix differs by {turned:.3g}: it is another arm, or another base",
        )
