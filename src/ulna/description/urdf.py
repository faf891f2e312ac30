"""Reads URDF (wiki.ros.org/urdf/XML); invalid elements are refused with file and line."""

import math
import re
from collections.abc import Iterator

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.document import Document
from ulna.description.pose import pose
from ulna.description.robot_description import Body, Description, Joint, JointType, Limits, Link, Mimic, Safety
from ulna.description.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from ulna.description.unread import RATES_SINCE, unused_rate, version_of
from ulna.description.xml import Reader, without_namespace
from ulna.errors import DescriptionError, did_you_mean
from ulna.kernels.layout import LARGEST

_OTHER_FORMATS = {"mujoco": "MJCF", "sdf": "SDF"}
_SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
_NEWEST: tuple[int, int] = (
    1,
    2,
)  # the versions of URDF that are known; 1.1 has quaternions and capsules, 1.2 accelerations and jerks


def read_urdf(document: Document) -> Description:
    """The description in a URDF document; its folder and its packages are the document's."""
    text = decoded(document)
    return _Reader(document.source).robot(without_namespace(document.root), text, document)


def decoded(document: Document) -> str:
    """The text of an XML document, without the encoding that it declares."""
    text, declared = document.text, document.root.getroottree().docinfo.encoding or "utf-8"
    marks = {b"\xff\xfe\0\0": "utf-32", b"\0\0\xfe\xff": "utf-32", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
    encoding = next((name for mark, name in marks.items() if text.startswith(mark)), declared)
    try:
        return re.sub(r"^\s*<\?xml[^>]*\?>", '<?xml version="1.0"?>', text.decode(encoding).lstrip("\ufeff"), count=1)
    except (LookupError, UnicodeDecodeError):
        raise DescriptionError(
            f"is written in {encoding}, which Python does not read; save it as UTF-8", document.source
        ) from None


class _Reader(Reader):
    """Reads one URDF document; holds its named materials."""

    def __init__(self, source: str) -> None:
        super().__init__(source)
        self.materials: dict[str, tuple[float, float, float, float]] = {}
        self.version: tuple[int, int] = (1, 0)

    def robot(self, root: etree._Element, text: str, document: Document) -> Description:
        if root.tag != "robot":
            other = f" but {_OTHER_FORMATS[root.tag]}, which is not read" if root.tag in _OTHER_FORMATS else ""
            raise self.fail(root, f"the root element is <{root.tag}>, not <robot>: this is not a URDF{other}")
        stated = version_of(root)
        self.version = self.version if stated is None else stated
        if self.version > _NEWEST:
            newest = ".".join(map(str, _NEWEST))
            raise self.fail(
                root, f"is URDF {root.get('version')}; versions up to {newest} are read, and what is newer may matter"
            )
        for material in root.iterfind("material"):
            color = self.color(material)
            if color is not None:
                self.materials[self.attribute(material, "name")] = color
        return Description(
            name=root.get("name", ""),
            links=tuple(self.link(element) for element in root.iterfind("link")),
            joints=tuple(self.joint(element) for element in root.iterfind("joint")),
            source=self.source,
            text=text,
            folder=document.folder,
            package_dirs=document.package_dirs,
        )

    def link(self, element: etree._Element) -> Link:
        name = self.attribute(element, "name")
        return Link(
            name=name,
            visuals=tuple(self.bodies(element, "visual", name)),
            collisions=tuple(self.bodies(element, "collision", name)),
            line=element.sourceline,
        )

    def bodies(self, link: etree._Element, tag: str, link_name: str) -> Iterator[Body]:
        elements = link.findall(tag)
        for k, element in enumerate(elements):
            geometry = self.only(element, "geometry")
            if geometry is None or len(geometry) == 0:
                raise self.fail(element, f"link {link_name!r}: <{tag}> has no <geometry>")
            material = self.only(element, "material")
            yield Body(
                name=element.get("name") or (f"{link_name}_{tag}" + (f"_{k + 1}" if len(elements) > 1 else "")),
                shape=self.shape(self.geometry(geometry, link_name), link_name),
                pose=self.origin(element),
                color=None if material is None else self.color(material),
            )

    def geometry(self, element: etree._Element, link_name: str) -> etree._Element:
        """The one shape in a geometry; other elements in it, such as a material, are ignored."""
        shapes = [child for child in element if child.tag in _SHAPES]
        if len(shapes) > 1:
            raise self.fail(shapes[1], f"link {link_name!r}: one <geometry> has {len(shapes)} shapes; one is expected")
        return shapes[0] if shapes else element[0]

    def shape(self, element: etree._Element, link_name: str) -> Shape:
        if element.tag == "box":
            return Box(self.triple(element, "size", low=0.0))
        if element.tag == "sphere":
            return Sphere(self.number(element, "radius", low=0.0))
        if element.tag in ("cylinder", "capsule"):
            kind = Cylinder if element.tag == "cylinder" else Capsule
            return kind(self.number(element, "radius", low=0.0), self.number(element, "length", low=0.0))
        if element.tag == "mesh":
            scale = self.triple(element, "scale") if "scale" in element.attrib else (1.0, 1.0, 1.0)
            return Mesh(self.attribute(element, "filename"), scale)
        raise self.fail(
            element, f"link {link_name!r}: geometry <{element.tag}> is not known; box, sphere, cylinder, capsule and mesh are"
        )

    def color(self, material: etree._Element) -> tuple[float, float, float, float] | None:
        element = self.only(material, "color")
        if element is None:
            return self.materials.get(material.get("name", ""))
        red, green, blue, alpha = self.vector(element, "rgba", 4)
        return red, green, blue, alpha

    def joint(self, element: etree._Element) -> Joint:
        name, kind = self.attribute(element, "name"), self.joint_type(element)
        return Joint(
            name=name,
            type=kind,
            parent=self.attribute(self.child(element, "parent"), "link"),
            child=self.attribute(self.child(element, "child"), "link"),
            origin=self.origin(element),
            axis=self.axis(element, name, kind),
            limits=self.limits(element, name, kind),
            mimic=self.mimic(element, name, kind),
            line=element.sourceline,
            safety=self.safety(element, name),
        )

    def joint_type(self, element: etree._Element) -> JointType:
        value = self.attribute(element, "type")
        if value not in list(JointType):
            raise self.fail(
                element, f"joint {element.get('name')!r}: type {value!r} is not known{did_you_mean(value, list(JointType))}"
            )
        return JointType(value)

    def axis(self, element: etree._Element, name: str, kind: JointType) -> NDArray[np.float64]:
        child = self.only(element, "axis")
        axis = np.array([1.0, 0.0, 0.0] if child is None else self.vector(child, "xyz", 3))
        if kind == JointType.FLOATING:
            return np.array([0.0, 0.0, 1.0])
        axis = axis / (np.abs(axis).max() or 1.0)
        length = float(np.linalg.norm(axis))
        if kind == JointType.FIXED:
            return axis if length == 0 else axis / length
        if length < 1e-9:
            raise self.fail(element, f"joint {name!r}: axis {tuple(axis.tolist())} has no direction, but the joint is {kind}")
        return axis / length

    def limits(self, element: etree._Element, name: str, kind: JointType) -> Limits:
        child = self.only(element, "limit")
        bounded = kind in (JointType.REVOLUTE, JointType.PRISMATIC)
        if child is None:
            if bounded and self.only(element, "mimic") is None:
                hint = "; a joint without limits is of type 'continuous'" if kind == JointType.REVOLUTE else ""
                raise self.fail(element, f"joint {name!r}: a {kind} joint needs a <limit>{hint}")
            return Limits()
        effort, velocity = (self.number(child, key, math.inf, 0.0) for key in ("effort", "velocity"))
        acceleration, jerk = (self.rate(child, key) for key in ("acceleration", "jerk"))
        deceleration = self.rate(child, "deceleration") if "deceleration" in child.attrib else acceleration
        if not bounded:
            return Limits(-math.inf, math.inf, velocity, effort, acceleration, deceleration, jerk)
        absent = next((key for key in ("lower", "upper") if key not in child.attrib), None)
        if absent is not None and self.version >= RATES_SINCE:
            raise self.fail(child, f"joint {name!r}: its <limit> has no {absent!r}, which URDF 1.2 needs of a {kind} joint")
        lower, upper = (self.number(child, key, 0.0) for key in ("lower", "upper"))
        if lower > upper:
            raise self.fail(child, f"joint {name!r}: lower limit {lower} is above upper limit {upper}")
        return Limits(lower, upper, velocity, effort, acceleration, deceleration, jerk)

    def rate(self, limit: etree._Element, key: str) -> float:
        """A limit of URDF 1.2; in an older version it is read too, but for a value that is not above 0, which limits nothing."""
        if self.version < RATES_SINCE and unused_rate(limit, key):
            return math.inf
        return self.number(limit, key, math.inf, 0.0)

    def safety(self, element: etree._Element, name: str) -> Safety | None:
        child = self.only(element, "safety_controller")
        if child is None:
            return None
        lower, upper = self.number(child, "soft_lower_limit", -math.inf), self.number(child, "soft_upper_limit", math.inf)
        if lower > upper:
            raise self.fail(child, f"joint {name!r}: soft lower limit {lower} is above soft upper limit {upper}")
        return Safety(self.number(child, "k_velocity"), self.number(child, "k_position", 0.0), lower, upper)

    def mimic(self, element: etree._Element, name: str, kind: JointType) -> Mimic | None:
        child = self.only(element, "mimic")
        if child is None:
            return None
        if kind not in (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC):
            if kind == JointType.FIXED:
                return None
            raise self.fail(child, f"joint {name!r}: a {kind} joint cannot mimic another")
        return Mimic(self.attribute(child, "joint"), self.number(child, "multiplier", 1.0), self.number(child, "offset", 0.0))

    def origin(self, element: etree._Element) -> NDArray[np.float64]:
        child = self.only(element, "origin")
        if child is None:
            return np.eye(4)
        zero = (0.0, 0.0, 0.0)
        xyz, rpy = (self.vector(child, key, 3) if key in child.attrib else zero for key in ("xyz", "rpy"))
        wxyz = self.quaternion(child, element) if "quat_xyzw" in child.attrib else None
        if max(map(abs, xyz)) > LARGEST:
            raise self.fail(child, f"{element.tag} {element.get('name', '')!r}: its origin is beyond {LARGEST:g} m")
        return pose(xyz, rpy) if wxyz is None else pose(xyz, wxyz=wxyz)

    def quaternion(self, origin: etree._Element, element: etree._Element) -> tuple[float, ...]:
        """The quaternion w, x, y, z of an origin of URDF 1.1, which has it as x, y, z, w."""
        where = f"{element.tag} {element.get('name', '')!r}"
        if "rpy" in origin.attrib:
            raise self.fail(origin, f"{where}: its origin has both rpy and quat_xyzw; one of them is expected")
        if self.version < (1, 1):
            advice = 'other programs ignore it; write <robot version="1.1"> if it is meant'
            raise self.fail(origin, f"{where}: quat_xyzw is of URDF 1.1, and this document is of an older version: {advice}")
        *xyz, w = self.vector(origin, "quat_xyzw", 4)
        if not any((w, *xyz)):
            raise self.fail(origin, f"{where}: quat_xyzw={origin.get('quat_xyzw')!r} has length 0, so it is no orientation")
        return w, *xyz
