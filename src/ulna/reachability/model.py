"""Writes a robot as JSON text that restores it bit for bit.

A map contains its robot, so a worker on another machine needs no robot file and no pickle, which could run code. Visuals, masses,
the source text and the semantic description are left out: no pose depends on them.
"""

import hashlib
import json
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from ulna.collision.allowed import AllowedCollisions, LinkPair
from ulna.collision.attached import Attached
from ulna.description.file_bytes import json_value
from ulna.description.robot_description import Body, Description, Inertia, Joint, JointType, Limits, Link, Mimic, Safety
from ulna.description.shapes import KINDS, ConvexMesh, Mesh
from ulna.dynamics.dynamics import FREE_FALL
from ulna.errors import DescriptionError
from ulna.kinematics.tree import Narrowed
from ulna.robot import Robot

_CLASSES = (Attached, Body, ConvexMesh, Description, Inertia, Joint, Limits, Link, LinkPair, Mesh, Mimic, Safety)
_KINDS = {kind.__name__: kind for kind in (*_CLASSES, *(kind.shape for kind in KINDS))}
_LEFT_OUT = {"line", "text", "source", "folder", "package_dirs", "srdf", "visuals", "color", "excess", "touched", "samples", "q"}
_OF_FORCES = {"inertia", "damping", "friction"}


def robot_to_json(robot: Robot, *, checked: bool, weighed: bool = False) -> str:
    """The text of a robot.

    checked: Whether collisions are checked, so that the pairs of links that may touch are included. weighed: Whether torques are
    computed, so that inertias and gravity are included.
    """
    allowed = [[pair.link_a, pair.link_b] for pair in robot.allowed_collisions] if checked else None
    left_out = _LEFT_OUT if weighed else _LEFT_OUT | _OF_FORCES
    data = {
        "description": _json_ready(robot.description, left_out),
        "home": robot.home.tolist(),
        "attached": [_json_ready(one, left_out) for one in robot.attached],
        "allowed": allowed,
    }
    if weighed:
        data["gravity"] = robot.gravity.tolist()
    if robot.tree.narrowed is not None:  # other robots keep their earlier text
        data["narrowed"] = {name: each.tolist() for name, each in robot.tree.narrowed._asdict().items()}
    return json.dumps(data, sort_keys=True, separators=(",", ":"))


def robot_from_json(text: str) -> Robot:
    """The robot of a text from ``robot_to_json``."""
    try:
        data = json_value(text)
        description = replace(_restore(data["description"]), source="a reachability map")
        attached = [_restore(one) for one in data["attached"]]
        pairs = data["allowed"]
        allowed = None if pairs is None else AllowedCollisions(tuple(LinkPair(a, b) for a, b in pairs))
        stated = data.get("narrowed")
        narrowed = None if stated is None else Narrowed(**{name: np.array(each, dtype=float) for name, each in stated.items()})
        gravity = data.get("gravity", FREE_FALL)
        return Robot(description, home=data["home"], attached=attached, allowed=allowed, gravity=gravity, _narrowed=narrowed)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DescriptionError(f"the map's robot cannot be read: {error}", "a reachability map") from error


def fingerprint(text: str) -> str:
    """The SHA-256 of a text, in hexadecimal digits."""
    return hashlib.sha256(text.encode()).hexdigest()


def _json_ready(value: Any, left_out: set[str]) -> Any:
    """Convert dataclasses to dictionaries with the name of their class, and arrays and tuples to lists."""
    if is_dataclass(value) and not isinstance(value, type):
        kept = {f.name: _json_ready(getattr(value, f.name), left_out) for f in fields(value) if f.name not in left_out}
        return {"kind": type(value).__name__, **kept}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, frozenset | set):
        return sorted(value)
    return [_json_ready(item, left_out) for item in value] if isinstance(value, tuple | list) else value


def _restore(value: Any) -> Any:
    if isinstance(value, dict):
        fields_ = {name: _restore(item) for name, item in value.items() if name != "kind"}
        if value["kind"] == "Joint":
            fields_["type"] = JointType(fields_["type"])
        return _KINDS[value["kind"]](**fields_)
    return tuple(_restore(item) for item in value) if isinstance(value, list) else value
