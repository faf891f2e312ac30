"""Reads the joints of an SDF document: axes, limits, and mimic relations."""

import math

import numpy as np
from lxml import etree

from ulna.description.pose import inverse
from ulna.description.robot_description import Joint, JointType, Limits, Link, Mimic
from ulna.description.sdf.collected import Z
from ulna.description.sdf.elements import FRAMES_SINCE, JOINT_AXES_SINCE, MIMIC_SINCE, Elements
from ulna.description.sdf.frames import MODEL, WORLD, Array
from ulna.errors import DescriptionError, cited, did_you_mean

_UNLIMITED = 1e16  # SDFormat: a limit of at least this size means no limit
_ROUNDING = 1e-13  # m: an axis closer to the origin of its link passes through it
_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_OTHERS = ("screw", "universal", "revolute2", "gearbox", "ball")


class Joints(Elements):
    """Reads the elements of one document, and its joints once all frames are known."""

    def joint(self, element: etree._Element, scope: str, key: str) -> tuple[list[Joint], list[Link]]:
        """Read a joint; if its axis misses its child's origin, add a link without shapes and a fixed joint between."""
        robot, frames, place = self.robot, self.robot.frames, self.place(element)
        name, kind, line = scope + self.name(element), self.joint_type(element), element.sourceline
        above = self.needed(element, "parent")
        parent = WORLD if above == WORLD else frames.body_of(frames.find(scope, above, place))
        child = frames.body_of(key)
        if parent == child:
            raise place.fail(f"joins link {child!r} to itself")
        if kind == JointType.FIXED:
            return [Joint(name, kind, parent, child, frames.between(parent, child), np.array(Z), line=line)], []
        axis_element = self.only(element, "axis")
        if axis_element is None:
            raise place.fail(f"is {kind} and has no <axis>")
        axis, limits, mimic = (
            self.axis(axis_element, scope, key),
            self.limits(axis_element, kind),
            self.mimic(axis_element, scope),
        )
        if kind == JointType.REVOLUTE and math.isinf(limits.lower) and math.isinf(limits.upper):
            kind = JointType.CONTINUOUS
        losses = dict(zip(("damping", "friction"), self.losses(axis_element), strict=True))
        T = frames.between(child, key)
        turned, offset = T[:3, :3] @ axis, T[:3, 3]
        if kind == JointType.PRISMATIC or np.abs(offset - (offset @ turned) * turned).max() <= _ROUNDING:
            origin = frames.between(parent, child)
            return [Joint(name, kind, parent, child, origin, turned, limits, mimic, line, **losses)], []
        between = robot.unused(f"{child}_at_{name}")
        joint = Joint(name, kind, parent, between, frames.between(parent, key), axis, limits, mimic, line, **losses)
        return [joint, robot.fixed(between, child, line, inverse(T))], [Link(between, line=line)]

    def joint_type(self, element: etree._Element) -> JointType:
        """The type of a joint with at most one degree of freedom."""
        value, place = self.attribute(element, "type"), self.place(element)
        if value in _OTHERS:
            raise place.fail(f"is a {value} joint, which is not read; {', '.join(_TYPES)} are")
        if value not in _TYPES:
            raise place.fail(f"type {cited(value)} is not known{did_you_mean(value, _TYPES)}")
        if element.find("axis2") is not None:
            raise place.fail(f"is {value}, and has a second axis")
        return JointType(value)

    def axis(self, element: etree._Element, scope: str, key: str) -> Array:
        """The axis as a unit vector in the frame of the joint."""
        frames, place, xyz = self.robot.frames, self.place(element), self.only(element, "xyz")
        axis = np.array(Z if xyz is None else self.floats(xyz, 3))
        axis = axis / (np.abs(axis).max() or 1.0)
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            raise place.fail("its axis has no direction")
        frame = "" if xyz is None else xyz.get("expressed_in", "")
        if frame:
            self.require_version(FRAMES_SINCE, element, "expressed_in")
        if element.find("use_parent_model_frame") is not None and self.version >= FRAMES_SINCE:
            raise place.fail('use_parent_model_frame is of SDF 1.5 and 1.6; write <xyz expressed_in="__model__">')
        if self.version < JOINT_AXES_SINCE or self.is_true(element, "use_parent_model_frame"):
            frame = MODEL
        return frames.between(key, frames.find(scope, frame, place))[:3, :3] @ axis / length if frame else axis / length

    def limits(self, axis: etree._Element, kind: JointType) -> Limits:
        """The limits of a joint; infinite if they are missing, or for a negative effort or velocity."""
        limit = self.only(axis, "limit")
        if limit is None:
            return Limits()
        lower, upper = self.bound(limit, "lower", -math.inf), self.bound(limit, "upper", math.inf)
        velocity, effort = (self.bound(limit, key, math.inf) for key in ("velocity", "effort"))
        velocity, effort = (math.inf if each < 0 else each for each in (velocity, effort))
        if kind == JointType.CONTINUOUS:
            if math.isfinite(lower) or math.isfinite(upper):
                self.leave_out(limit, "lower and upper of a continuous joint are not used; with type revolute they are")
            return Limits(velocity=velocity, effort=effort)
        if lower > upper or lower == math.inf or upper == -math.inf:
            raise self.place(limit).fail(f"lower limit {lower} and upper limit {upper} leave no range")
        return Limits(lower, upper, velocity, effort)

    def losses(self, axis: etree._Element) -> tuple[float, float]:
        """The damping and friction of a joint, on which no pose depends; 0 with a note if faulty."""
        try:
            dynamics = self.only(axis, "dynamics")
            return self.given(dynamics, "damping", 0.0, 0.0), self.given(dynamics, "friction", 0.0, 0.0)
        except DescriptionError as error:
            self.leave_out(axis, f"{error.message}: damping and friction are taken as 0", is_warned=False)
            return 0.0, 0.0

    def bound(self, limit: etree._Element, tag: str, default: float) -> float:
        """A limit; infinite if it is so large that SDF means none."""
        child = self.only(limit, tag)
        if child is None:
            return default
        values = self.parsed(child, child.text or "")
        if len(values) != 1 or math.isnan(values[0]):
            raise self.place(limit).fail(f"<{tag}> {cited(child.text)}: one number is expected")
        return math.copysign(math.inf, values[0]) if abs(values[0]) >= _UNLIMITED else values[0]

    def mimic(self, axis: etree._Element, scope: str) -> Mimic | None:
        """The leader of a mimic joint: position = multiplier * (position of the leader - reference) + offset."""
        child = self.only(axis, "mimic")
        if child is None:
            return None
        self.require_version(MIMIC_SINCE, child, "<mimic>")
        if child.get("axis", "axis") != "axis":
            raise self.place(axis).fail("follows the second axis of a joint, which is not read")
        elements = {tag: self.only(child, tag) for tag in ("multiplier", "offset", "reference")}
        given = {tag: self.floats(element, 1)[0] for tag, element in elements.items() if element is not None}
        ratio = given.get("multiplier", 1.0)
        offset = given.get("offset", 0.0) - ratio * given.get("reference", 0.0)
        return Mimic(scope + self.attribute(child, "joint"), ratio, offset)
