"""Checks joints, their types, limits, axes and angles, and the names of links and joints."""

import math
from collections.abc import Iterator

from lxml import etree

from ulna.description.robot_description import JointType
from ulna.errors import did_you_mean
from ulna.inspection.elements import number, numbers, of_robot
from ulna.inspection.result import Finding, Severity

_TWO_TURNS = 4 * math.pi
_UNIT = 1e-3  # how far the length of an axis may be from 1 and count as rounded


def joint_findings(root: etree._Element) -> Iterator[Finding]:
    """What is wrong with single joints, and angles anywhere that look like degrees."""
    for joint in root.iterfind("joint"):
        kind = joint.get("type", "")
        if kind not in list(JointType):
            message = f"type {kind!r} is not known{did_you_mean(kind, list(JointType))}"
            yield Finding(Severity.ERROR, of_robot(joint), message, joint.sourceline)
            continue
        yield from _limit_findings(joint, JointType(kind))
        if kind not in (JointType.FIXED, JointType.FLOATING):
            yield from _axis_findings(joint)
    for origin in root.iter("origin"):
        rpy = numbers(origin, "rpy")
        if rpy is not None and max(map(abs, rpy)) > 2 * math.pi + 1e-3:
            message = f'rpy="{origin.get("rpy")}" is more than a turn: degrees? Angles are radians'
            yield Finding(Severity.WARNING, of_robot(origin), message, origin.sourceline)


def _limit_findings(joint: etree._Element, kind: JointType) -> Iterator[Finding]:
    limit, where = joint.find("limit"), of_robot(joint)
    if kind in (JointType.REVOLUTE, JointType.PRISMATIC):
        if limit is None and joint.find("mimic") is None:
            yield Finding(Severity.ERROR, where, f"a {kind} joint without <limit>", joint.sourceline)
        elif limit is not None:
            yield from _range_findings(limit, where, kind)
    if limit is None or kind == JointType.FIXED:
        return
    if kind == JointType.CONTINUOUS and {"lower", "upper"} & set(limit.attrib):
        yield Finding(Severity.NOTE, where, "lower and upper of a continuous joint are not used", limit.sourceline)
    for key in ("velocity", "effort"):
        value = number(limit, key)
        if key not in limit.attrib:
            yield Finding(Severity.NOTE, where, f"no {key} limit: taken as unlimited", limit.sourceline)
        elif value is not None and value <= 0:
            severity = Severity.WARNING if value == 0 else Severity.ERROR
            yield Finding(severity, where, f"{key} limit is {value:g}", limit.sourceline)


def _range_findings(limit: etree._Element, where: str, kind: JointType) -> Iterator[Finding]:
    lower, upper = (0.0 if key not in limit.attrib else number(limit, key) for key in ("lower", "upper"))
    if lower is None or upper is None:
        return
    if lower > upper:
        yield Finding(Severity.ERROR, where, f"lower limit {lower:g} is above upper limit {upper:g}", limit.sourceline)
    elif lower == upper:
        given = f"both {lower:g}" if {"lower", "upper"} & set(limit.attrib) else "not given, so both 0"
        yield Finding(Severity.WARNING, where, f"lower and upper limit are {given}: it cannot move", limit.sourceline)
    widest = max(abs(lower), abs(upper))
    if kind == JointType.REVOLUTE and widest > _TWO_TURNS:
        hint = "degrees? Angles are radians" if widest <= 720 else "a joint without limits is of type 'continuous'"
        yield Finding(
            Severity.WARNING, where, f"limits {lower:g} to {upper:g} rad are more than two turns: {hint}", limit.sourceline
        )
    if kind == JointType.PRISMATIC and widest > 20:
        yield Finding(
            Severity.WARNING, where, f"limits {lower:g} to {upper:g} m: millimetres? Lengths are metres", limit.sourceline
        )


def _axis_findings(joint: etree._Element) -> Iterator[Finding]:
    axis, where = joint.find("axis"), of_robot(joint)
    if axis is None:
        yield Finding(Severity.NOTE, where, "no <axis>: the x axis is taken, as URDF says", joint.sourceline)
        return
    xyz = numbers(axis, "xyz")
    if xyz is None:
        return
    length = math.hypot(*xyz)
    if length == 0:
        yield Finding(Severity.ERROR, where, "axis 0 0 0 has no direction", joint.sourceline)
    elif abs(length - 1) > _UNIT:
        yield Finding(Severity.WARNING, where, f'axis "{axis.get("xyz")}" has length {length:.4g}: normalised', axis.sourceline)


def name_findings(root: etree._Element) -> Iterator[Finding]:
    """What is wrong with the names of links and joints, and with what refers to them."""
    for tag in ("link", "joint"):
        yield from _repeated(root, tag)
    links = {element.get("name", "") for element in root.iterfind("link")}
    joints = {element.get("name", "") for element in root.iterfind("joint")}
    for joint in root.iterfind("joint"):
        for tag, key, known in (("parent", "link", links), ("child", "link", links), ("mimic", "joint", joints)):
            name = "" if (element := joint.find(tag)) is None else element.get(key, "")
            if element is not None and name not in known:
                message = f"<{tag}> {key} {name!r} is not defined{did_you_mean(name, known)}"
                yield Finding(Severity.ERROR, of_robot(joint), message, joint.sourceline)


def _repeated(root: etree._Element, tag: str) -> Iterator[Finding]:
    exact: set[str] = set()
    folded: dict[str, str] = {}
    for element in root.iterfind(tag):
        name, where = element.get("name", ""), of_robot(element)
        if not name:
            yield Finding(Severity.ERROR, where, f"a <{tag}> without a name", element.sourceline)
        elif name in exact:
            yield Finding(Severity.ERROR, where, "defined twice", element.sourceline)
        elif name.casefold() in folded:
            message = f"differs from {folded[name.casefold()]!r} by case only"
            yield Finding(Severity.WARNING, where, message, element.sourceline)
        exact.add(name)
        folded.setdefault(name.casefold(), name)
