"""Checks a robot that loads: its reach, mimic joints, its SRDF, and the convex hulls of its meshes."""

import math
from collections.abc import Iterator

import numpy as np

from ulna.description.meshes.hulls import n_collision_meshes
from ulna.description.robot_description import Description, Joint, JointType
from ulna.description.semantic import Srdf
from ulna.description.shapes import Mesh
from ulna.description.structure import Drive, bounds_of_q, columns_of_q, drives_of, hard_bounds, joints_from_root
from ulna.errors import UlnaError, count_of, listed
from ulna.inspection.result import NOTE, WARNING, Finding
from ulna.robot import Robot

_LARGEST_REACH, _MIN_REACH = 20.0, 0.01  # [m]
_NARROWING_TOLERANCE = 0.05  # fraction of a range: smaller differences are the rounding of published limits
_NOTE_SHARE, _WARNING_SHARE = 0.1, 0.5  # fractions of the random configurations: the bounds of a note and of a warning
_ADVICE = (
    "If the meshes do not touch: robot.with_allowed_collisions(at=q) allows what touches at a q or a state of the SRDF that is "
    "known to be free, robot.with_allowed_collisions([(link, link)]) single pairs, and meshes='decompose' follows hollows"
)


def robot_findings(robot: Robot, reach: float) -> Iterator[Finding]:
    """Findings about a robot that loads."""
    yield from _contradictions(robot.description)
    yield from _srdf_findings(robot.description.srdf)
    if any(joint.damping or joint.friction for joint in robot.description.joints):
        yield Finding(NOTE, "document", "damping and friction are read and written, but no torque includes them")
    if reach > _LARGEST_REACH:
        yield Finding(WARNING, "document", f"it reaches {reach:.3g} m when stretched: millimeters? Lengths are meters")
    elif robot.n_dof and 0 < reach < _MIN_REACH:
        yield Finding(WARNING, "document", f"it reaches {reach:.3g} m when stretched: scaled twice?")
    yield from hull_findings(robot)


def _srdf_findings(srdf: Srdf) -> Iterator[Finding]:
    if srdf.found_at:
        allowed = f"it allows contacts of {count_of(len(srdf.disabled_collisions), 'pair')} of links"
        yield Finding(NOTE, "document", f"{srdf.found_at} is next to the URDF and is used; {allowed}")
        for sentence in srdf.warnings:
            yield Finding(WARNING, "document", sentence)
    for sentence in srdf.passed_over:
        yield Finding(NOTE, "document", sentence)


def stretched_length(robot: Robot) -> float:
    """The length of the longest chain [m]: the sum of its joints' distances, with prismatic joints at their finite limits."""
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
    _, ignored = bounds_of_q(joints, drives, hard_bounds)
    own = {joint.name: hard_bounds(joint) for joint in joints}
    leaders = {column.start: name for name, column in columns.items()}
    for joint in joints:
        drive = drives[joint.name]
        if joint.mimic is None or drive.column is None:
            continue
        where = f"joint {joint.name!r}"
        if drive.ratio == 0:
            yield Finding(WARNING, where, f"mimics {joint.mimic.joint!r} with multiplier 0: it does not move", joint.line)
        elif joint.name in ignored and joint.limits.lower < joint.limits.upper:
            message = f"its limits leave no range for {leaders[drive.column]!r}, which it mimics: they are ignored"
            yield Finding(WARNING, where, message, joint.line)
        elif (narrowed := _narrowed(joint, drive, own[leaders[drive.column]])) is not None:
            message = f"its limits narrow {leaders[drive.column]!r}, which it mimics, to {narrowed[0]:.4g} to {narrowed[1]:.4g}"
            yield Finding(WARNING, where, message, joint.line)


def _narrowed(joint: Joint, drive: Drive, own: tuple[float, float]) -> tuple[float, float] | None:
    """The range that a mimic joint leaves its leader, out of its ``own``; None if nearly all of it."""
    if joint.type not in (JointType.REVOLUTE, JointType.PRISMATIC) or joint.limits.lower >= joint.limits.upper:
        return None
    low, high = sorted((bound - drive.offset) / drive.ratio for bound in hard_bounds(joint))
    left = max(low, own[0]), min(high, own[1])
    width = own[1] - own[0]
    return left if math.isfinite(width) and left[1] - left[0] < (1 - _NARROWING_TOLERANCE) * width else None


def hull_findings(robot: Robot) -> Iterator[Finding]:
    """Findings about checked pairs of links with meshes that touch as convex hulls. Unreadable meshes have their own findings."""
    if not n_collision_meshes(robot.description) or not robot.n_dof:
        return
    meshed = {link.name for link in robot.description.links if any(isinstance(body.shape, Mesh) for body in link.collisions)}
    try:
        hulls = robot.with_convex_hulls()
        pairs = sorted(hulls.allowed_collisions.touching(_NOTE_SHARE), key=lambda pair: (-pair.touched, pair.link_a, pair.link_b))
        home = hulls.check_collision(hulls.home).pairs
    except UlnaError:
        return
    often = [pair for pair in pairs if not meshed.isdisjoint(pair.links)]
    if often:
        words = [f"{pair.link_a} and {pair.link_b} at {pair.touched} ({pair.touched / pair.samples:.0%})" for pair in often]
        severity = WARNING if often[0].touched >= _WARNING_SHARE * often[0].samples else NOTE
        yield Finding(severity, "document", f"hulls touch at some of {often[0].samples} random q: {listed(words)}. {_ADVICE}")
    touching = {frozenset((pair.link_a, str(pair.link_b))) for pair in home if pair.signed_distance <= 0.0}
    at_home = [" and ".join(sorted(links)) for links in touching if not meshed.isdisjoint(links)]
    if at_home:
        message = (
            f"hulls touch at robot.home: {listed(sorted(at_home))}. If it is free: robot.with_allowed_collisions(at=robot.home)"
        )
        yield Finding(NOTE, "document", message)
