"""Computes the commands of a motion; refuses motions beyond an arm's limits, and descriptions of other arms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.arms.arm import FR3, ArmModel
from ulna.description.arrays import as_number
from ulna.description.pose import inverse
from ulna.errors import InputError, count_of
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot

Array = NDArray[np.float64]
PERIOD = 0.001  # [s], between two commands of a Franka
START_TOLERANCE = 0.01  # [rad], distance of the arm from a motion's start
MAX_TOLERANCE = 0.03  # [rad]: the approach over twice this distance needs 9 rad/s^2 and 450 rad/s^3
_APPROACH = 0.2  # [s], duration of the approach to a motion's start
_POSITION_ROUNDING = 1e-9  # [rad], rounding of a position at its limit
_AXIS_TOLERANCE = 1e-3  # [m], and entry of a rotation matrix: between the last axis of a description and the measured one
_LIMIT_ROUNDING = 1e-6  # [rad], rounding of the limits in a description


def as_tolerance(value: object) -> float:
    """Check the allowed distance of the arm from a motion's start [rad].

    Raises:
        InputError: It is not a number from 0 to MAX_TOLERANCE.
    """
    return as_number("start_tolerance", value, 0.0, f"a number from 0 to {MAX_TOLERANCE} rad", most=MAX_TOLERANCE)


def commands_of(motion: Trajectory, model: ArmModel, q: Array, *, speed: float, tolerance: float) -> Array:
    """The positions to command, shape (n, n_dof) [rad or m], one each PERIOD; the last is the motion's end.

    Args:
        motion: A motion from rest to rest, with jerk limits.
        model: The model of the arm.
        q: The current position of the arm, shape (n_dof,) [rad or m].
        speed: The fraction of the motion's speed, above 0 and at most 1.
        tolerance: Maximum distance of a joint from the motion's start [rad or m].

    Raises:
        InputError: The motion has other joints, no jerk limits, another start, or exceeds a limit of the arm at this speed; or
            the speed is out of range.
    """
    if not isinstance(motion, Trajectory):
        raise InputError(
            "motion", f"{type(motion).__name__}; an ulna.Trajectory is expected, as plan.trajectory(jerk=...) returns"
        )
    speed = as_number("speed", speed, 0.0, "a fraction of the motion's speed, above 0 and at most 1", above=True, most=1.0)
    if len(motion.joint_names) != model.n_dof:
        raise InputError(
            "motion", f"it moves {count_of(len(motion.joint_names), 'joint')}, and the {model.name} has {model.n_dof}"
        )
    if motion.duration > 0.0 and not motion.limits_jerk:
        raise InputError("motion", "its acceleration jumps, so the arm would abort it; plan.trajectory(jerk=...) limits the jerk")
    if motion.end_velocities.any():
        raise InputError(
            "motion",
            "it does not start and end at rest, as the arm does; leave out start_velocity and end_velocity",
        )
    away = np.abs(motion.q[0] - q)
    joint = int(np.argmax(away))
    if not away[joint] <= tolerance:
        raise InputError(
            "motion",
            f"it starts {away[joint]:.4g} rad from the measured position of {motion.joint_names[joint]}; "
            f"{tolerance:g} rad are allowed; plan from arm.q",
        )
    motion = motion if speed == 1.0 else motion.slowed(speed)
    commands = motion.sampled(PERIOD).q
    outside = (commands < model.lower - _POSITION_ROUNDING) | (commands > model.upper + _POSITION_ROUNDING)
    if outside.any():
        row, joint = np.argwhere(outside)[0]
        raise InputError(
            "motion",
            f"{motion.joint_names[joint]} goes to {commands[row, joint]:.4f} rad; the limits of the {model.name} are "
            f"{model.lower[joint]:.4f} and {model.upper[joint]:.4f} rad",
        )
    judged = motion.check(model.limits, period=PERIOD)
    if not judged:
        raise InputError("motion", f"the {model.name} would abort it: {judged}")
    return commands


def approach(q: Array, start: Array) -> Array:
    """The commands from rest at q to rest at a motion's start, shape (n, n_dof); none if both are equal.

    A line with the time law 10 s^3 - 15 s^4 + 6 s^5: 0.01 rad in 0.2 s needs 1.5 rad/s^2 and 75 rad/s^3.
    """
    if np.array_equal(q, start):
        return np.empty((0, len(q)))
    s = np.arange(PERIOD, _APPROACH + PERIOD / 2, PERIOD)[:-1, None] / _APPROACH
    return q + (start - q) * (s**3 * (10 - 15 * s + 6 * s * s))


def refuse_another_robot(robot: Robot, q: ArrayLike, T_base_flange: Array) -> None:
    """Refuse a description that is not a Franka Research 3's.

    The flange's position along the axis of the last joint is not compared: a simulator measures the frame of that joint instead.

    Args:
        robot: The loaded description.
        q: The measured position of the arm, shape (7,) [rad].
        T_base_flange: The measured pose of the flange at q, shape (4, 4).

    Raises:
        InputError: It has other joints or wider limits, or the axis of its last joint differs from the measured one.
    """
    moving = [joint for joint in robot.description.joints if joint.name in robot.joint_names]
    if robot.n_dof != FR3.n_dof or any(joint.type not in {"revolute", "continuous"} for joint in moving):
        raise InputError(
            "robot", f"{robot.name} has {count_of(robot.n_dof, 'entry', 'entries')} of q, and a {FR3.name} has 7 revolute joints"
        )
    wide = [
        name
        for name, low, high, least, most in zip(robot.joint_names, robot.lower, robot.upper, FR3.lower, FR3.upper, strict=True)
        if low < least - _LIMIT_ROUNDING or high > most + _LIMIT_ROUNDING
    ]
    if wide:
        raise InputError("robot", f"the limits of {', '.join(wide)} of {robot.name} are wider than those of a {FR3.name}")
    last = next(joint for joint in moving if joint.name == robot.joint_names[-1])
    first = next(joint for joint in moving if joint.name == robot.joint_names[0])
    T_first, T_last = (robot.forward_kinematics(np.array(q), link=link) for link in (first.parent, last.child))
    described = inverse(T_first) @ T_last
    moved, turned = described[:3, 3] - T_base_flange[:3, 3], np.abs(described[:3, :3] - T_base_flange[:3, :3]).max()
    beside = np.linalg.norm(moved - described[:3, 2] * (described[:3, 2] @ moved))
    if not max(beside, turned) <= _AXIS_TOLERANCE:
        raise InputError(
            "robot",
            f"the last joint axis of {robot.name} is {beside * 1e3:.1f} mm off the measured one, and its rotation matrix "
            f"differs by {turned:.3g}: it is another arm, or another base",
        )
