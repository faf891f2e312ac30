"""Runs every check on a description and lists its tree."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from ulna.description.robot_description import Description, JointType
from ulna.description.semantic import Srdf
from ulna.description.structure import bounds_of_q, columns_of_q, drives_of, hard_bounds, joints_from_root
from ulna.errors import DescriptionError
from ulna.ik.closed_form.closed_form import closed_form_of
from ulna.inspection.elements import element_findings
from ulna.inspection.inspected import Inspected, read_inspected, tree_rows
from ulna.inspection.joints import joint_findings, name_findings
from ulna.inspection.links import inertia_findings, shape_findings
from ulna.inspection.meshes import mesh_findings
from ulna.inspection.result import Finding, Inspection, Severity
from ulna.inspection.touching_hulls import hull_findings
from ulna.robot import Robot
from ulna.robot.hand_link import hand_link

_LARGEST_REACH, _LEAST_REACH = 20.0, 0.01


def robot_findings(robot: Robot, reach: float) -> Iterator[Finding]:
    """What is wrong with a robot that loads."""
    yield from _contradictions(robot.description)
    yield from _srdf_findings(robot.description.srdf)
    if reach > _LARGEST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: millimetres? Lengths are metres")
    elif robot.n_dof and 0 < reach < _LEAST_REACH:
        yield Finding(Severity.WARNING, "document", f"it reaches {reach:.3g} m when stretched: scaled twice?")
    yield from hull_findings(robot)


def _srdf_findings(srdf: Srdf) -> Iterator[Finding]:
    if srdf.found_at:
        allowed = f"{len(srdf.disabled_collisions)} pairs of links may touch by it"
        yield Finding(Severity.NOTE, "document", f"{srdf.found_at} lies beside the URDF and is used; {allowed}")
        for sentence in srdf.warnings:
            yield Finding(Severity.NOTE, "document", sentence)
    for sentence in srdf.passed_over:
        yield Finding(Severity.NOTE, "document", sentence)


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
    """The closed form of the hand's inverse kinematics; empty if the arm has none."""
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


def inspect(
    source: str | Path, *, xacro_args: Mapping[str, object] | None = None, package_dirs: Iterable[str | Path] = ()
) -> Inspection:
    """The health of a robot description, also of one that ``ulna.load`` refuses: that error is then the first finding.

    Args:
        source: A bundled name, the path of a ``.urdf``, ``.xacro`` or ``.urdf.xacro`` file, or URDF text.
        xacro_args: Arguments of a xacro file, or of the one macro that it defines.
        package_dirs: Folders in which the packages of ``package://`` and ``$(find ...)`` lie.

    Returns:
        An ``Inspection``: its ``findings`` are errors, then warnings, then notes. ``print`` it.

    Raises:
        FileError: There is no such file, or it cannot be read.

    Example:
        >>> print(inspect('<robot name="r"><link name="a"/><link name="A"/></robot>'))
        URDF text: cannot be loaded
        error document: 2 links have no parent (a, A): one root is expected
        warning link 'A': differs from 'a' by case only
        note document: no link has a visual shape
        note document: no link has a collision shape
    """
    package_dirs = tuple(package_dirs) if isinstance(package_dirs, Iterator) else package_dirs  # it is gone through twice
    document = read_inspected(source, xacro_args or {}, package_dirs)
    robot, root = document.robot, document.root
    reach = None if robot is None else stretched_length(robot)
    found = list(_findings(document, reach))
    ordered = [finding for severity in Severity for finding in found if finding.severity == severity]
    return Inspection(
        source=document.source,
        name="" if root is None else root.get("name", ""),
        loads=robot is not None,
        findings=tuple(ordered),
        tree=() if root is None else tree_rows(root),
        n_links=0 if root is None else len(root.findall("link")),
        joint_types={} if root is None else dict(Counter(joint.get("type", "") for joint in root.iterfind("joint"))),
        n_dof=None if robot is None else robot.n_dof,
        reach=reach,
        closed_form="" if robot is None else closed_form_in_words(robot),
    )


def _findings(document: Inspected, reach: float | None) -> Iterator[Finding]:
    error, root = document.error, document.root
    line = error.line if isinstance(error, DescriptionError) else None
    if error is not None:
        message = error.message if isinstance(error, DescriptionError) else str(error)
        yield Finding(Severity.ERROR, "document", message, line)
    if root is None:
        return
    own = [*element_findings(root), *name_findings(root), *joint_findings(root), *shape_findings(root), *inertia_findings(root)]
    yield from own if error is None else _without_repeated(own, line)
    yield from mesh_findings(root, document)
    yield from (Finding(Severity.WARNING, "document", sentence) for sentence in document.warnings)
    if document.robot is not None and reach is not None:
        yield from robot_findings(document.robot, reach)


def _without_repeated(findings: list[Finding], line: int | None) -> list[Finding]:
    """The findings without the first error on the line of the error of ``ulna.load``, which reports the same fault."""
    repeated = next(
        (k for k, one in enumerate(findings) if one.severity == Severity.ERROR and one.line == line is not None), None
    )
    return [one for k, one in enumerate(findings) if k != repeated]
