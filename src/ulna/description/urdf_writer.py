"""Writes a description as URDF text: for robots without a file, or parts of one."""

import math
from dataclasses import asdict, replace

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.pose import rpy_from_matrix
from ulna.description.robot_description import Body, Description, Inertia, Joint, JointType
from ulna.description.shapes import IN_URDF, Mesh, Shape, UnknownShape, kind_of
from ulna.description.unread import ATTRIBUTES
from ulna.errors import DescriptionError, InputError


def write_urdf(description: Description) -> str:
    """The URDF document of a description: kinematics, limits, shapes, inertias, damping and friction.

    It omits parts for other programs, such as ``<transmission>``, which a description does not contain.
    """
    robot = etree.Element("robot", {"name": description.name, **_version(description)})
    for link in description.links:
        element = etree.SubElement(robot, "link", name=link.name)
        if link.inertia is not None:
            element.append(_inertial(link.inertia))
        for tag, bodies in (("visual", link.visuals), ("collision", link.collisions)):
            element.extend(_body(tag, body) for body in bodies)
    robot.extend(_joint(joint) for joint in description.joints)
    return etree.tostring(robot, pretty_print=True, encoding="unicode")


def expressible_in_urdf(description: Description) -> Description:
    """The part of a description that URDF can express: no other shapes; unlimited prismatic joints become continuous.

    It is for findings only, since such a joint no longer slides.
    """
    kept = (Mesh, *(kind.shape for kind in IN_URDF.values()))
    links = (
        replace(
            link,
            visuals=tuple(body for body in link.visuals if isinstance(body.shape, kept)),
            collisions=tuple(body for body in link.collisions if isinstance(body.shape, kept)),
        )
        for link in description.links
    )
    joints = (replace(joint, type=JointType.CONTINUOUS) if _is_endless(joint) else joint for joint in description.joints)
    return replace(description, links=tuple(links), joints=tuple(joints))


def _is_endless(joint: Joint) -> bool:
    """Whether a joint has no limit on one side or both, which URDF cannot express."""
    bounded = joint.type in (JointType.PRISMATIC, JointType.REVOLUTE) and joint.mimic is None
    return bounded and (math.isinf(joint.limits.lower) or math.isinf(joint.limits.upper))


def _version(description: Description) -> dict[str, str]:
    """The lowest version of URDF that expresses a description; none for 1.0."""
    limits = [joint.limits for joint in description.joints]
    if any(math.isfinite(min(each.acceleration, each.deceleration, each.jerk)) for each in limits):
        return {"version": "1.2"}
    kinds = (kind_of(body.shape) for link in description.links for body in (*link.visuals, *link.collisions))
    major, minor = max((kind.urdf_since for kind in kinds if kind is not None), default=(1, 0))
    return {"version": f"{major}.{minor}"} if minor else {}


def _inertial(inertia: Inertia) -> etree._Element:
    """An inertia in the axes of its link, so that a reader need not rotate its tensor."""
    element = etree.Element("inertial")
    etree.SubElement(element, "origin", xyz=_words(inertia.center), rpy=_words([0.0, 0.0, 0.0]))
    etree.SubElement(element, "mass", value=_words([inertia.mass]))
    upper = inertia.tensor[np.triu_indices(3)].tolist()
    numbers = zip(ATTRIBUTES["inertia"], upper, strict=True)
    etree.SubElement(element, "inertia", {key: _words([number]) for key, number in numbers})
    return element


def _body(tag: str, body: Body) -> etree._Element:
    element = etree.Element(tag, name=body.name)
    element.append(_origin(body.pose))
    etree.SubElement(element, "geometry").append(_shape(body.shape))
    if body.color is not None:
        material = etree.SubElement(element, "material", name=f"{body.name}_color")
        etree.SubElement(material, "color", rgba=_words(body.color))
    return element


def _shape(shape: Shape) -> etree._Element:
    kind = kind_of(shape)
    if kind is not None:
        if not kind.urdf:
            raise InputError("description", f"URDF has no {kind.word}, so it cannot be written")
        keys = zip(kind.urdf, kind.sizes, strict=True)
        return etree.Element(kind.word, {key: _words(np.atleast_1d(getattr(shape, size))) for key, size in keys})
    match shape:
        case Mesh(uri, scale):
            return etree.Element("mesh", filename=uri, scale=_words(scale))
        case UnknownShape(kind):
            raise InputError("description", f"{kind} is not known, so it cannot be written")
        case _:
            raise InputError("description", "URDF has no convex hulls; write the robot as it was before with_convex_hulls()")


def _joint(joint: Joint) -> etree._Element:
    element = etree.Element("joint", name=joint.name, type=_type(joint))
    etree.SubElement(element, "parent", link=joint.parent)
    etree.SubElement(element, "child", link=joint.child)
    element.append(_origin(joint.origin))
    if joint.type not in (JointType.FIXED, JointType.FLOATING):
        etree.SubElement(element, "axis", xyz=_words(joint.axis))
    unused = {"lower", "upper"} if joint.type == JointType.CONTINUOUS else set()
    limits = _finite({key: value for key, value in asdict(joint.limits).items() if key not in unused})
    if limits and joint.type != JointType.FIXED:
        etree.SubElement(element, "limit", limits)
    if joint.damping or joint.friction:
        etree.SubElement(element, "dynamics", damping=_words([joint.damping]), friction=_words([joint.friction]))
    if joint.mimic is not None:
        mimic = joint.mimic
        etree.SubElement(
            element, "mimic", joint=mimic.joint, multiplier=_words([mimic.multiplier]), offset=_words([mimic.offset])
        )
    if joint.safety is not None:
        safety = joint.safety
        soft = {"soft_lower_limit": safety.soft_lower, "soft_upper_limit": safety.soft_upper}
        gains = {"k_velocity": safety.k_velocity, "k_position": safety.k_position}
        etree.SubElement(element, "safety_controller", _finite({**gains, **soft}))
    return element


def _finite(numbers: dict[str, float]) -> dict[str, str]:
    return {key: _words([number]) for key, number in numbers.items() if math.isfinite(number)}


def _type(joint: Joint) -> JointType:
    """The joint's type in URDF, which has no revolute joint without limits: it becomes continuous."""
    infinite = [math.isinf(limit) for limit in (joint.limits.lower, joint.limits.upper)]
    if joint.type == JointType.REVOLUTE and all(infinite) and joint.mimic is None:
        return JointType.CONTINUOUS
    if joint.type in (JointType.REVOLUTE, JointType.PRISMATIC) and any(infinite) and joint.mimic is None:
        raise DescriptionError(f"joint {joint.name!r} has no finite limits, which URDF requires of a {joint.type} joint")
    return joint.type


def _origin(T: NDArray[np.float64]) -> etree._Element:
    return etree.Element("origin", xyz=_words(T[:3, 3]), rpy=_words(rpy_from_matrix(T)))


def _words(values) -> str:
    return " ".join(repr(float(value)) for value in values)
