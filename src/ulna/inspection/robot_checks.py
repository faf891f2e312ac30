"""Checks the whole robot: mimic joints that leave no range, and an implausible reach."""

import math
from collections.abc import Iterator

import numpy as np

from ulna.description.robot_description import Description, JointType
from ulna.description.structure import bounds_of_q, columns_of_q, drives_of, hard_bounds, joints_from_root
from ulna.ik.closed_form.closed_form import closed_form_of
from ulna.inspection.result import Finding, Severity
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link

_LARGEST_REACH, _LEAST_REACH = 20.0, 0.01


def robot_findings(robot: Robot, reach: float) -> Iterator[Finding]:
    """What is wrong with a robot that loads."""
    yield from _contradictions(robot.description)
    if reach > _LARGEST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: millimetres? Lengths are metres")
    elif robot.n_dof and 0 < reach < _LEAST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: scaled twice?")


def stretched_length(robot: Robot) -> float:
    """The length of the longest chain [m]: its joints' distances in sum, slides drawn out to their finite limits."""
    far = {robot.base: 0.0}
    for joint in joints_from_root(robot.description):
        slide = 0.0
        if joint.type == JointType.PRISMATIC:
            slide = max((abs(limit) for limit in (joint.limits.lower, joint.limits.upper) if math.isfinite(limit)), default=0.0)
        far[joint.child] = far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3])) + slide
    return max(far.values())


def closed_form_in_words(robot: Robot) -> str:
    """The closed form of the hand's inverse kinematics; empty if there is none."""
    form = closed_form_of(robot.tree, robot.tip or hand_link(robot))
    return "" if form is None else str(form)


def _contradictions(description: Description) -> Iterator[Finding]:
    joints = joints_from_root(description)
    columns = columns_of_q(joints)
    drives = drives_of(joints, columns, description.source)
    _, ignored = bounds_of_q(joints, drives, hard_bounds)
    leaders = {column.start: name for name, column in columns.items()}
    for joint in joints:
        drive = drives[joint.name]
        if joint.mimic is None or drive.column is None:
            continue
        where = f"joint {joint.name!r}"
        if drive.ratio == 0:
            yield Finding(
                Severity.WARNING, where, f"mimics {joint.mimic.joint!r} with multiplier 0: it does not move", joint.line
            )
        elif joint.name in ignored and joint.limits.lower < joint.limits.upper:
            message = f"its limits leave {leaders[drive.column]!r}, which it mimics, no room: they are ignored"
            yield Finding(Severity.WARNING, where, message, joint.line)
