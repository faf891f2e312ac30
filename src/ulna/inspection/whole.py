"""What only the whole robot shows: followers that leave their leader no room, and a reach that no arm has."""

import math
from collections.abc import Iterator

import numpy as np

from ulna.inspection.result import Finding, Severity
from ulna.model.description import Description, JointType
from ulna.model.structure import columns_of_q, drives_of, follower_range, hard_bounds, joints_from_root
from ulna.robot import Robot

_LARGEST_REACH, _LEAST_REACH = 20.0, 0.01


def robot_findings(robot: Robot, reach: float) -> Iterator[Finding]:
    """What is wrong with a robot that loads."""
    yield from _contradictions(robot.description)
    if reach > _LARGEST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: millimetres? Lengths are metres")
    elif robot.n_dof and 0 < reach < _LEAST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: scaled twice?")


def reach_of(robot: Robot) -> float:
    """The length of the longest chain [m]: its joints' distances in sum, slides drawn out to their finite limits."""
    far = {robot.base: 0.0}
    for joint in joints_from_root(robot.description):
        slide = 0.0
        if joint.type == JointType.PRISMATIC:
            slide = max((abs(limit) for limit in (joint.limits.lower, joint.limits.upper) if math.isfinite(limit)), default=0.0)
        far[joint.child] = far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3])) + slide
    return max(far.values())


def _contradictions(description: Description) -> Iterator[Finding]:
    joints = joints_from_root(description)
    columns = columns_of_q(joints)
    drives = drives_of(joints, columns, description.source)
    leaders = {columns[joint.name].start: joint for joint in joints if joint.name in columns}
    for joint in joints:
        drive = drives[joint.name]
        if joint.mimic is None or drive.column is None:
            continue
        where = f"joint {joint.name!r}"
        if drive.ratio == 0:
            yield Finding(Severity.WARNING, where, f"mimics {joint.mimic.joint!r} with multiplier 0: it stands still", joint.line)
            continue
        leader, follower = leaders[drive.column], follower_range(hard_bounds(joint), drive)
        low, high = max(leader.limits.lower, follower[0]), min(leader.limits.upper, follower[1])
        if follower[0] < follower[1] and not low < high:
            message = f"its limits and those of {leader.name!r}, which it mimics, leave no room: its own are passed over"
            yield Finding(Severity.WARNING, where, message, joint.line)
