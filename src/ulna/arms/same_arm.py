"""Compares a robot's description with the arm that is connected."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.arms.arm_model import FR3
from ulna.errors import InputError
from ulna.robot import Robot

Array = NDArray[np.float64]
_AT_FLANGE = 0.107  # [m], from the frame of the last joint to the flange, along its z axis
_NEAR = 1e-3  # [m], and of a rotation matrix: of a description's flange from the measured one
_ROUNDED = 1e-6  # [rad], of the limits in a description


def refuse_another_robot(robot: Robot, q: ArrayLike, T_base_flange: Array) -> None:
    """Refuse a description that is not a Franka Research 3's.

    Args:
        robot: The description, loaded.
        q: Where the arm is measured, shape (7,) [rad].
        T_base_flange: Where it says that its flange is then, shape (4, 4).

    Raises:
        InputError: It has other joints or wider limits, or its flange is elsewhere than measured.
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
    described = np.linalg.inv(T_first) @ T_last
    described[:3, 3] += _AT_FLANGE * described[:3, 2]
    away = np.abs(described - T_base_flange)
    if not away.max() <= _NEAR:
        raise InputError(
            "robot",
            f"{robot.name} has its flange {np.linalg.norm(described[:3, 3] - T_base_flange[:3, 3]) * 1e3:.1f} mm from where the "
            f"arm measures it, turned by up to {away[:3, :3].max():.3g}: it is another arm, or another base",
        )
