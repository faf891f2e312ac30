"""Finds unread parts of a URDF document, and whether they may change a pose, a shape or a limit."""

import difflib
import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from lxml import etree

from ulna.description.shapes import IN_URDF

# For each element the children and the attributes that are read, or checked by ``inspect``.
CHILDREN = {
    "robot": ("link", "joint", "material", "frame", "fixed_frame"),
    "fixed_frame": ("parent", "origin"),
    "link": ("visual", "collision", "inertial"),
    "joint": ("parent", "child", "origin", "axis", "limit", "mimic", "safety_controller", "dynamics"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "inertial": ("origin", "mass", "inertia"),
    "geometry": (*IN_URDF, "mesh"),
    "material": ("color",),
}
ATTRIBUTES = {
    "robot": ("name", "version"),
    "frame": ("name", "link", "xyz", "rpy"),
    "fixed_frame": ("name",),
    "link": ("name",),
    "visual": ("name",),
    "collision": ("name",),
    "material": ("name",),
    "joint": ("name", "type"),
    "parent": ("link",),
    "child": ("link",),
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"),
    "mimic": ("joint", "multiplier", "offset"),
    "safety_controller": ("k_velocity", "k_position", "soft_lower_limit", "soft_upper_limit"),
    "dynamics": ("damping", "friction"),
    **{word: kind.urdf for word, kind in IN_URDF.items()},
    "mesh": ("filename", "scale"),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "color": ("rgba",),
}
# Parts for other programs, and parts that change neither a pose nor a shape, a limit or a collision.
_OTHERS = {
    "robot": {"gazebo", "mujoco", "ros2_control", "sensor", "transmission", "verbose"},
    "link": {"contact", "contact_coefficients", "gravity", "kinematic", "self_filter", "sensor", "surface", "verbose"},
    "joint": {"calibration"},
    "collision": {"contact", "contact_coefficients", "material", "surface", "verbose"},
    "geometry": {"material"},
    "mesh": {"declare_convex"},
}
_OTHER_ATTRIBUTES = {
    "joint": {"dont_collapse"},
    "limit": {"command_effort", "current", "gear_velocity"},
}
RATES, RATES_SINCE = ("acceleration", "deceleration", "jerk"), (1, 2)  # of a <limit>, and the first version of URDF that has them
_LOOKS = {"dynamics", "inertial", "material", "visual"}  # their content changes no pose, shape, limit or collision
_NAMED = {"geometry", "link", "robot", "collision", *_LOOKS}  # their other attributes are names and notes
_LIKENESS = 0.8  # "efort" is meant to be "effort"; "gear_velocity" is something else  # codespell:ignore efort
_LOOP = "it closes a loop of joints, which is not supported: its links move without it"
_SHAPES = "its shapes are not checked for collisions; <collision> is read"
_REASONS = {
    "loop_joint": _LOOP,
    "constraint": _LOOP,
    "ball_constraint": _LOOP,
    "linear_bushing_rpy": _LOOP,
    "collision_filter_group": "an SRDF says which links may touch (srdf=)",
    "self_collision_checking": _SHAPES,
    "collision_checking": _SHAPES,
    "position_based_velocity_limits": 'limits="fr3" gives those of an FR3',
}


class Unread(NamedTuple):
    """A part of a document that is not read.

    Attributes:
        element: The element, or the one that has the attribute or text.
        what: Its name, such as "<dynamics> in <joint>".
        message: A sentence about it; empty if it is for other programs.
        matters: Whether it may change a pose, a shape, a limit or a collision.
    """

    element: etree._Element
    what: str
    message: str
    matters: bool


def version_of(root: etree._Element) -> tuple[int, int] | None:
    """The stated version of a URDF document, by default (1, 0); None if it is not two numbers like "1.0"."""
    stated = re.fullmatch(r"([0-9]{1,4})\.([0-9]{1,4})", root.get("version", "1.0"))
    return None if stated is None else (int(stated[1]), int(stated[2]))


def unused_rate(limit: etree._Element, key: str) -> bool:
    """Whether a limit of URDF 1.2 in an older document has no effect: no finite number above 0."""
    try:
        value = float(limit.get(key, "nan"))
    except ValueError:
        return True
    return not 0.0 < value < np.inf


def unread_parts(root: etree._Element) -> Iterator[Unread]:
    """The elements, attributes and texts that are not read."""
    version = version_of(root)
    if version is None:
        stated = f"version {root.get('version', '')[:40]!r} is not two numbers; '1.0' is used"
        yield Unread(root, "attribute 'version' of <robot>", stated, matters=True)
    waiting = [(root, False)]
    while waiting:
        element, of_looks = waiting.pop()
        tag = str(element.tag)
        of_looks = of_looks or tag in _LOOKS
        yield from _attributes(element, tag, of_looks=of_looks)
        if tag == "limit" and (version or (1, 0)) < RATES_SINCE:
            yield from _unused_rates(element)
        if tag in ATTRIBUTES and tag not in _NAMED and tag != "joint" and (element.text or "").strip():
            text = " ".join((element.text or "").split())[:40]
            yield Unread(element, f"text in <{tag}>", f"the text {text!r} in <{tag}> is not read", not of_looks)
        if tag == "joint":
            yield from _unused_range(element)
        read = CHILDREN.get(tag, ())
        known = [child for child in element.iterchildren(etree.Element) if child.tag in read]
        waiting.extend((child, of_looks) for child in reversed(known))
        for child in element.iterchildren(etree.Element):
            if child.tag not in read and (known or tag != "geometry"):  # the reader reports an unknown shape
                yield _element(child, tag, of_looks=of_looks)


def sentences(root: etree._Element, source: str) -> list[str]:
    """A sentence with file and line for each unread part that matters."""
    parts = (part for part in unread_parts(root) if part.matters)
    return [f"{source}:{part.element.sourceline}: {of_robot(part.element)}: {part.message}" for part in parts]


def of_robot(element: etree._Element) -> str:
    """The joint, link or document that contains an element, in words."""
    for one in (element, *element.iterancestors()):
        if one.tag in ("joint", "link"):
            return f"{one.tag} {one.get('name', '')!r}"
    return "document"


def _element(child: etree._Element, parent: str, *, of_looks: bool) -> Unread:
    name, of_others = etree.QName(child), _OTHERS.get(parent, ())
    tag, what = name.localname, f"<{name.localname}> in <{parent}>"
    if name.namespace is None and (near := _intended_name(tag, CHILDREN.get(parent, ()))):
        return Unread(child, what, f"{what} is not known, and left out; did you mean <{near}>?", not of_looks)
    if parent == "robot" and tag == "gazebo":
        ties = next((part.tag for part in child.iterchildren("joint", "link", "model", "include")), None)
        if ties is None:
            return Unread(child, what, "", matters=False)
        return Unread(child, what, f"a <{ties}> in <gazebo> is not read: its additions are missing", matters=True)
    is_for_others = name.namespace is not None and tag not in _REASONS
    is_hint = tag == "collision_checking" and child.find(".//geometry") is None  # it tells Pinocchio which shapes to replace
    if of_looks or is_for_others or is_hint or tag in of_others or (tag == "origin" and _is_identity(child)):
        return Unread(child, what, "", matters=False)
    reason = f": {_REASONS[tag]}" if tag in _REASONS else ""
    return Unread(child, what, f"{what} is not read{reason}", matters=True)


def _attributes(element: etree._Element, tag: str, *, of_looks: bool) -> Iterator[Unread]:
    known = ATTRIBUTES.get(tag, ())
    for key in map(str, element.attrib):
        name = etree.QName(key)
        if key in known or not known or (name.namespace is not None and tag != "limit"):
            continue
        what = f"attribute {name.localname!r} of <{tag}>"
        if name.namespace is None and (near := _intended_name(key, known)):
            yield Unread(element, what, f"{what} is not known, and left out; did you mean {near!r}?", not of_looks)
        elif tag in _NAMED or of_looks or name.localname in _OTHER_ATTRIBUTES.get(tag, ()):
            yield Unread(element, what, "", matters=False)
        else:
            yield Unread(element, what, f"{what} is not read", matters=True)


def _unused_rates(limit: etree._Element) -> Iterator[Unread]:
    for key in RATES:
        if key in limit.attrib and unused_rate(limit, key):
            message = f"{key} {limit.get(key, '')[:40]!r} is not a number above 0, so it sets no limit"
            yield Unread(limit, f"attribute {key!r} of <limit>", message, matters=True)


def _unused_range(joint: etree._Element) -> Iterator[Unread]:
    """The range of a continuous joint, which its type ignores; it matters if it is narrower than a turn."""
    limit = joint.find("limit")
    if joint.get("type") != "continuous" or limit is None or not {"lower", "upper"} & set(limit.attrib):
        return
    what = "range of a continuous joint"
    try:
        width = float(limit.get("upper", "0")) - float(limit.get("lower", "0"))
    except ValueError:
        width = 0.0
    message = "lower and upper of a continuous joint are not used; with type revolute they are"
    matters = 0.0 < width < 2 * np.pi - 1e-3
    yield Unread(limit, what, message if matters else "", matters)


def _is_identity(origin: etree._Element) -> bool:
    try:
        return not np.any([float(word) for key in ("xyz", "rpy") for word in origin.get(key, "").split()])
    except ValueError:
        return False


def _intended_name(name: str, known: Iterable[str]) -> str | None:
    """The known name that a misspelt one was meant to be."""
    return next(iter(difflib.get_close_matches(name, known, n=1, cutoff=_LIKENESS)), None)
