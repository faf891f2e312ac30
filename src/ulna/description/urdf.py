"""Reads URDF (wiki.ros.org/urdf/XML); invalid elements are refused with file and line."""

import math
import re
from collections.abc import Iterator

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from ulna.description.document import Document, xacro_elements
from ulna.description.pose import pose
from ulna.description.robot_description import (
    Body,
    Description,
    Inertia,
    Joint,
    JointType,
    LeftOut,
    Limits,
    Link,
    Mimic,
    Safety,
)
from ulna.description.shapes import IN_URDF, Mesh, Shape, UnknownShape
from ulna.description.unread import ATTRIBUTES, RATES_SINCE, of_robot, unused_rate, version_of
from ulna.description.xml import Reader, without_namespace
from ulna.errors import DescriptionError, cited, did_you_mean
from ulna.kernels.layout import LARGEST

_OTHER_FORMATS = {"mujoco": "MJCF, which ulna.load reads", "gazebo": "SDF of before 1.3, which is not read; 1.4 is"}
_SHAPES = (*IN_URDF, "mesh")
_NEWEST: tuple[int, int] = (
    1,
    2,
)  # the supported versions of URDF; 1.1 has quaternions and capsules, 1.2 accelerations and jerks


def read_urdf(document: Document) -> Description:
    """The description in a URDF document; its folder and its packages are the document's."""
    text = decoded(document)
    return _Reader(document.source).robot(without_namespace(document.root), text, document)


def decoded(document: Document) -> str:
    """The text of an XML document, without the encoding that it declares."""
    text, declared = document.parsed.text, document.root.getroottree().docinfo.encoding or "utf-8"
    marks = {b"\xff\xfe\0\0": "utf-32", b"\0\0\xfe\xff": "utf-32", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
    encoding = next((name for mark, name in marks.items() if text.startswith(mark)), declared)
    try:
        return re.sub(r"^\s*<\?xml[^>]*\?>", '<?xml version="1.0"?>', text.decode(encoding).lstrip("\ufeff"), count=1)
    except (LookupError, UnicodeDecodeError):
        raise DescriptionError(
            f"is written in {encoding}, which Python does not read; save it as UTF-8", document.source
        ) from None


def inertia_of(link: etree._Element, source: str = "") -> Inertia | None:
    """The inertia of a ``<link>``; None without one.

    Raises:
        DescriptionError: It is faulty.
    """
    reader = _Reader(source)
    reader.version = version_of(link.getroottree().getroot()) or reader.version
    return reader.given_inertia(link)


class _Reader(Reader):
    """Reads one URDF document; holds its named materials."""

    def __init__(self, source: str) -> None:
        super().__init__(source)
        self.materials: dict[str, tuple[float, float, float, float]] = {}
        self.version: tuple[int, int] = (1, 0)
        self.left_out: list[LeftOut] = []

    def leave_out(self, element: etree._Element, message: str, *, is_warned: bool = True) -> None:
        """Record a faulty part on which no pose depends."""
        self.left_out.append(LeftOut(of_robot(element), message, element.sourceline, is_warned))

    def robot(self, root: etree._Element, text: str, document: Document) -> Description:
        if root.tag != "robot":
            other = f" but {_OTHER_FORMATS[root.tag]}" if root.tag in _OTHER_FORMATS else ""
            raise self.fail(root, f"the root element is <{root.tag}>, not <robot>: this is not a URDF{other}")
        stated = version_of(root)
        self.version = self.version if stated is None else stated
        if self.version > _NEWEST:
            newest = ".".join(map(str, _NEWEST))
            raise self.fail(
                root, f"is URDF {root.get('version')}; versions up to {newest} are read, and newer elements may matter"
            )
        if document.parsed.mended:
            message = f"is not well-formed XML, as other programs may say: {document.parsed.mended}"
            self.leave_out(root, message, is_warned=False)
        for call in xacro_elements(root):
            name = etree.QName(call).localname
            message = f"<xacro:{name}> is left out: this document does not define that macro, so its contents are missing"
            self.leave_out(call, message)
        for material in root.iterfind("material"):
            color = self.color(material)
            if color is not None:
                self.materials[material.get("name", "")] = color
        links = [self.link(element) for element in root.iterfind("link")]
        joints = [self.joint(element) for element in root.iterfind("joint")]
        self.add_frames(root, links, joints)
        return Description(
            name=root.get("name", ""),
            links=tuple(links),
            joints=tuple(joints),
            source=self.source,
            text=text,
            folder=document.folder,
            package_dirs=document.package_dirs,
            left_out=tuple(self.left_out),
        )

    def add_frames(self, root: etree._Element, links: list[Link], joints: list[Joint]) -> None:
        """Read each <frame> of Drake and <fixed_frame> of Isaac Sim as a link without shapes on a fixed joint."""
        known, taken, axis = {link.name for link in links}, {joint.name for joint in joints}, np.array([1.0, 0.0, 0.0])
        for element in root.iterchildren("frame", "fixed_frame"):
            try:
                name, of_drake = self.attribute(element, "name"), element.tag == "frame"
                parent = self.attribute(element if of_drake else self.child(element, "parent"), "link")
                origin = self.placed(element, element) if of_drake else self.origin(element)
                if name in known:
                    raise self.fail(element, f"<{element.tag}> {name!r} has the name of a link")
                if parent not in known:
                    raise self.fail(
                        element, f"<{element.tag}> {name!r}: link {parent!r} is not defined{did_you_mean(parent, known)}"
                    )
            except DescriptionError as error:
                self.leave_out(element, f"{error.message}: this frame is left out")
                continue
            joint = f"{name}_fixed"
            while joint in taken:
                joint += "_"
            known.add(name)
            taken.add(joint)
            links.append(Link(name, line=element.sourceline))
            joints.append(Joint(joint, JointType.FIXED, parent, name, origin, axis, line=element.sourceline))

    def link(self, element: etree._Element) -> Link:
        name = self.attribute(element, "name")
        return Link(
            name=name,
            visuals=tuple(self.bodies(element, "visual", name)),
            collisions=tuple(self.bodies(element, "collision", name)),
            line=element.sourceline,
            inertia=self.inertia(element),
        )

    def inertia(self, link: etree._Element) -> Inertia | None:
        """The inertia of a link; a faulty one is omitted."""
        try:
            return self.given_inertia(link)
        except DescriptionError as error:
            message = f"{error.message}: this inertia is left out, so it has none"
            self.left_out.append(LeftOut(of_robot(link), message, error.line or link.sourceline, is_warned=False))
            return None

    def given_inertia(self, link: etree._Element) -> Inertia | None:
        """The inertia of a link, in its axes; the document may state it in other axes, by rpy."""
        inertial = self.only(link, "inertial")
        if inertial is None:
            return None
        mass, numbers = self.number(self.child(inertial, "mass"), "value", low=0.0), self.child(inertial, "inertia")
        moments = [self.number(numbers, key) for key in ATTRIBUTES["inertia"]]
        return Inertia.stated(mass, moments, self.origin(inertial))

    def bodies(self, link: etree._Element, tag: str, link_name: str) -> Iterator[Body]:
        """The shapes of a link; faulty visuals are omitted, unknown collision shapes stay as ``UnknownShape``."""
        elements = link.findall(tag)
        for k, element in enumerate(elements):
            name = element.get("name") or (f"{link_name}_{tag}" + (f"_{k + 1}" if len(elements) > 1 else ""))
            try:
                yield Body(name, self.shape(element, tag), self.origin(element), self.color_of(element))
            except DescriptionError as error:
                if tag != "visual":
                    raise
                message = f"{error.message}: this visual is left out, so it is not drawn"
                self.left_out.append(LeftOut(of_robot(element), message, error.line))

    def shape(self, body: etree._Element, tag: str) -> Shape:
        """The one shape in a visual or collision; other elements in its geometry, such as a material, are ignored."""
        geometry = self.only(body, "geometry")
        children = [] if geometry is None else list(geometry)
        shapes = [child for child in children if child.tag in _SHAPES]
        if len(shapes) > 1:
            raise self.fail(shapes[1], f"{of_robot(body)}: one <geometry> has {len(shapes)} shapes; one is expected")
        element = shapes[0] if shapes else next(iter(children), None)
        if element is not None and shapes and not self.is_foreign(element):
            return self.known_shape(element)
        kind = "an empty <geometry>" if element is None else f"<{element.tag}>"
        if element is not None and shapes:
            kind += " with " + ", ".join(f"{key}={cited(value)}" for key, value in element.attrib.items() if key != "filename")
        if tag == "visual":
            raise self.fail(body if element is None else element, f"geometry {kind} is not known")
        message = f"collision geometry {kind} is not known: poses can be computed, collisions cannot"
        self.leave_out(body if element is None else element, message)
        return UnknownShape(kind)

    def is_foreign(self, shape: etree._Element) -> bool:
        """Whether a shape has the measures of other formats: a capsule end points, a mesh one or four factors."""
        if shape.tag == "mesh":
            return bool(shape.get("filename")) and "scale" in shape.attrib and len(self.numbers(shape, "scale")) != 3
        needed = [key for key in ATTRIBUTES[str(shape.tag)] if key != "scale"]
        others = set(shape.attrib) - set(ATTRIBUTES[str(shape.tag)])
        return bool(others) and not all(key in shape.attrib for key in needed)

    def known_shape(self, element: etree._Element) -> Shape:
        if element.tag != "mesh":
            kind = IN_URDF[str(element.tag)]
            keys = zip(kind.urdf, kind.sizes.values(), strict=True)
            return kind.shape(
                *(self.triple(element, key, low=0.0) if n == 3 else self.number(element, key, low=0.0) for key, n in keys)
            )
        scale = self.triple(element, "scale") if "scale" in element.attrib else (1.0, 1.0, 1.0)
        return Mesh(self.attribute(element, "filename"), scale)

    def color_of(self, body: etree._Element) -> tuple[float, float, float, float] | None:
        """The color of a body: that of its first material."""
        materials = body.findall("material")
        if len(materials) > 1:
            self.leave_out(materials[1], f"<{body.tag}> has {len(materials)} <material>: the first is used")
        return self.color(materials[0]) if materials else None

    def color(self, material: etree._Element) -> tuple[float, float, float, float] | None:
        """The color of a material; None with a note if it has no readable one."""
        elements = material.findall("color")
        if not elements:
            return self.materials.get(material.get("name", ""))
        if len(elements) > 1:
            self.leave_out(elements[1], f"<material> {material.get('name')!r} has {len(elements)} <color>: the first is used")
        try:
            red, green, blue, alpha = self.vector(elements[0], "rgba", 4)
        except DescriptionError as error:
            self.leave_out(elements[0], f"{error.message}: this color is left out")
            return None
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
            safety=self.safety(element, name, kind),
            damping=self.loss(element, "damping", kind),
            friction=self.loss(element, "friction", kind),
        )

    def joint_type(self, element: etree._Element) -> JointType:
        value = self.attribute(element, "type")
        if value not in list(JointType):
            raise self.fail(
                element, f"joint {element.get('name')!r}: type {value!r} is not known{did_you_mean(value, list(JointType))}"
            )
        return JointType(value)

    def axis(self, element: etree._Element, name: str, kind: JointType) -> NDArray[np.float64]:
        """The axis of a joint as a unit vector; types without an axis get x or z in any case."""
        if kind in (JointType.FIXED, JointType.FLOATING):
            return np.array([1.0, 0.0, 0.0] if kind == JointType.FIXED else [0.0, 0.0, 1.0])
        child = self.only(element, "axis")
        axis = np.array([1.0, 0.0, 0.0] if child is None else self.vector(child, "xyz", 3))
        axis = axis / (np.abs(axis).max() or 1.0)
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            raise self.fail(element, f"joint {name!r}: axis {tuple(axis.tolist())} has no direction, but the joint is {kind}")
        return axis / length

    def limits(self, element: etree._Element, name: str, kind: JointType) -> Limits:
        if kind == JointType.FIXED:
            return Limits()
        child = self.only(element, "limit")
        bounded = kind in (JointType.REVOLUTE, JointType.PRISMATIC)
        if child is None:
            if bounded and self.only(element, "mimic") is None:
                hint = "; a joint without limits is of type 'continuous'" if kind == JointType.REVOLUTE else ""
                raise self.fail(element, f"joint {name!r}: a {kind} joint needs a <limit>{hint}")
            return Limits()
        effort, velocity = (self.most(child, key) for key in ("effort", "velocity"))
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

    def most(self, limit: etree._Element, key: str) -> float:
        """A limit on effort or velocity; infinite with a note if it is negative or no number, which means "unknown"."""
        try:
            return self.number(limit, key, math.inf, 0.0)
        except DescriptionError:
            unlimited = limit.get(key, "").strip().lower() in ("inf", "infinity", "+inf")
            message = f"{key}={cited(limit.get(key))} is not a number of at least 0: treated as unlimited"
            self.leave_out(limit, message, is_warned=key == "velocity" and not unlimited)
            return math.inf

    def rate(self, limit: etree._Element, key: str) -> float:
        """A limit of URDF 1.2; in an older document a value of at most 0 limits nothing."""
        if self.version < RATES_SINCE and unused_rate(limit, key):
            return math.inf
        return self.number(limit, key, math.inf, 0.0)

    def safety(self, element: etree._Element, name: str, kind: JointType) -> Safety | None:
        child = None if kind == JointType.FIXED else self.only(element, "safety_controller")
        if child is None:
            return None
        lower, upper = self.number(child, "soft_lower_limit", -math.inf), self.number(child, "soft_upper_limit", math.inf)
        if lower > upper:
            raise self.fail(child, f"joint {name!r}: soft lower limit {lower} is above soft upper limit {upper}")
        return Safety(self.number(child, "k_velocity"), self.number(child, "k_position", 0.0), lower, upper)

    def loss(self, element: etree._Element, key: str, kind: JointType) -> float:
        """The damping or friction of a joint, on which no pose depends; 0 with a note if faulty."""
        try:
            child = None if kind == JointType.FIXED else self.only(element, "dynamics")
            return 0.0 if child is None else self.number(child, key, 0.0, 0.0)
        except DescriptionError as error:
            message = f"{error.message}: {key} is taken as 0"
            self.left_out.append(LeftOut(of_robot(element), message, error.line, is_warned=False))
            return 0.0

    def mimic(self, element: etree._Element, name: str, kind: JointType) -> Mimic | None:
        child = None if kind == JointType.FIXED else self.only(element, "mimic")
        if child is None:
            return None
        if kind not in (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC):
            raise self.fail(child, f"joint {name!r}: a {kind} joint cannot mimic another")
        return Mimic(self.attribute(child, "joint"), self.number(child, "multiplier", 1.0), self.number(child, "offset", 0.0))

    def origin(self, element: etree._Element) -> NDArray[np.float64]:
        child = self.only(element, "origin")
        return np.eye(4) if child is None else self.placed(child, element)

    def placed(self, child: etree._Element, element: etree._Element) -> NDArray[np.float64]:
        """The pose of an element from the attributes of a child."""
        zero = (0.0, 0.0, 0.0)
        xyz, rpy = (self.vector(child, key, 3) if key in child.attrib else zero for key in ("xyz", "rpy"))
        wxyz = self.quaternion(child, element) if "quat_xyzw" in child.attrib else None
        if max(map(abs, xyz)) > LARGEST:
            raise self.fail(child, f"{element.tag} {element.get('name', '')!r}: its origin is beyond {LARGEST:g} m")
        return pose(xyz, rpy) if wxyz is None else pose(xyz, wxyz=wxyz)

    def quaternion(self, origin: etree._Element, element: etree._Element) -> tuple[float, ...]:
        """The quaternion w, x, y, z of an origin of URDF 1.1, which states it as x, y, z, w."""
        where = f"{element.tag} {element.get('name', '')!r}"
        if "rpy" in origin.attrib:
            raise self.fail(origin, f"{where}: its origin has both rpy and quat_xyzw; one of them is expected")
        if self.version < (1, 1):
            advice = 'other programs ignore it; if it is intended, write <robot version="1.1">'
            raise self.fail(origin, f"{where}: quat_xyzw is of URDF 1.1, and this document is of an older version: {advice}")
        *xyz, w = self.vector(origin, "quat_xyzw", 4)
        if not any((w, *xyz)):
            raise self.fail(origin, f"{where}: quat_xyzw={origin.get('quat_xyzw')!r} has length 0, so it is not an orientation")
        return w, *xyz
