"""Checks joints, their types, limits, axes and angles, and the names of links and joints."""

import math
from collections.abc import Iterator

from lxml import etree

from ulna.description.robot_description import JointType
from ulna.description.unread import RATES, RATES_SINCE, version_of
from ulna.errors import did_you_mean
from ulna.inspection.elements import finding_at, number, numbers
from ulna.inspection.result import ERROR, NOTE, WARNING, Finding

_TWO_TURNS = 4 * math.pi
_UNIT = 1e-3  # deviation of an axis's length from 1 that counts as rounding


def joint_findings(root: etree._Element) -> Iterator[Finding]:
    """Findings about single joints, and about angles that look like degrees."""
    for joint in root.iterfind("joint"):
        kind = joint.get("type", "")
        if kind not in list(JointType):
            yield finding_at(ERROR, joint, f"type {kind!r} is not known{did_you_mean(kind, list(JointType))}")
            continue
        yield from _limit_findings(joint, JointType(kind))
        if kind not in (JointType.FIXED, JointType.FLOATING):
            yield from _axis_findings(joint)
    for origin in root.iter("origin"):
        rpy = numbers(origin, "rpy")
        if rpy is not None and max(map(abs, rpy)) > 2 * math.pi + 1e-3:
            yield finding_at(WARNING, origin, f'rpy="{origin.get("rpy")}" is more than a turn: degrees? Angles are radians')


def _limit_findings(joint: etree._Element, kind: JointType) -> Iterator[Finding]:
    limit = joint.find("limit")
    if kind in (JointType.REVOLUTE, JointType.PRISMATIC):
        if limit is None and joint.find("mimic") is None:
            yield finding_at(ERROR, joint, f"a {kind} joint without <limit>")
        elif limit is not None:
            yield from _range_findings(limit, kind)
    if limit is None or kind == JointType.FIXED:
        return
    for key in ("velocity", "effort"):
        value = number(limit, key)
        if key not in limit.attrib:
            yield finding_at(NOTE, limit, f"no {key} limit: treated as unlimited")
        elif value is not None and value <= 0:
            yield finding_at(WARNING if value == 0 else ERROR, limit, f"{key} limit is {value:g}")
    version = version_of(limit.getroottree().getroot()) or (1, 0)
    for key in RATES if version >= RATES_SINCE else ():
        if number(limit, key) == 0:
            yield finding_at(WARNING, limit, f"{key} limit is 0")


def _range_findings(limit: etree._Element, kind: JointType) -> Iterator[Finding]:
    lower, upper = (0.0 if key not in limit.attrib else number(limit, key) for key in ("lower", "upper"))
    if lower is None or upper is None:
        return
    if lower > upper:
        yield finding_at(ERROR, limit, f"lower limit {lower:g} is above upper limit {upper:g}")
    elif lower == upper:
        given = f"both {lower:g}" if {"lower", "upper"} & set(limit.attrib) else "not given, so both 0"
        yield finding_at(WARNING, limit, f"lower and upper limit are {given}: it cannot move")
    widest = max(abs(lower), abs(upper))
    if kind == JointType.REVOLUTE and widest > _TWO_TURNS:
        hint = "degrees? Angles are radians" if widest <= 720 else "a joint without limits is of type 'continuous'"
        yield finding_at(WARNING, limit, f"limits {lower:g} to {upper:g} rad are more than two turns: {hint}")
    if kind == JointType.PRISMATIC and widest > 20:
        yield finding_at(WARNING, limit, f"limits {lower:g} to {upper:g} m: millimeters? Lengths are meters")


def _axis_findings(joint: etree._Element) -> Iterator[Finding]:
    axis = joint.find("axis")
    if axis is None:
        yield finding_at(NOTE, joint, "no <axis>: the x axis is used, URDF's default")
        return
    xyz = numbers(axis, "xyz")
    if xyz is None:
        return
    length = math.hypot(*xyz)
    if length == 0:
        yield finding_at(ERROR, joint, "axis 0 0 0 has no direction")
    elif abs(length - 1) > _UNIT:
        yield finding_at(WARNING, axis, f'axis "{axis.get("xyz")}" has length {length:.4g}: normalized')


def name_findings(root: etree._Element) -> Iterator[Finding]:
    """Findings about the names of links and joints, and about references to them."""
    for tag in ("link", "joint"):
        yield from _repeated(root, tag)
    links = {element.get("name", "") for element in root.iterfind("link")}
    joints = {element.get("name", "") for element in root.iterfind("joint")}
    for joint in root.iterfind("joint"):
        for tag, key, known in (("parent", "link", links), ("child", "link", links), ("mimic", "joint", joints)):
            name = "" if (element := joint.find(tag)) is None else element.get(key, "")
            if element is not None and name not in known:
                yield finding_at(ERROR, joint, f"<{tag}> {key} {name!r} is not defined{did_you_mean(name, known)}")


def _repeated(root: etree._Element, tag: str) -> Iterator[Finding]:
    exact: set[str] = set()
    folded: dict[str, str] = {}
    for element in root.iterfind(tag):
        name = element.get("name", "")
        if not name:
            yield finding_at(ERROR, element, f"a <{tag}> without a name")
        elif name in exact:
            yield finding_at(ERROR, element, "defined twice")
        elif name.casefold() in folded:
            yield finding_at(WARNING, element, f"differs from {folded[name.casefold()]!r} by case only")
        exact.add(name)
        folded.setdefault(name.casefold(), name)
