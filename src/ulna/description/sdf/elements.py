"""Reads the elements of one SDF document: numbers in texts, poses, links with their shapes."""

import math
import re
from collections.abc import Iterator

import numpy as np
from lxml import etree

from ulna.description.pose import pose
from ulna.description.robot_description import Body, Inertia, LeftOut, Link
from ulna.description.sdf.collected import Collected
from ulna.description.sdf.files import Included
from ulna.description.sdf.frames import WORLD, Array, Place
from ulna.description.sdf.unread import unread_parts
from ulna.description.shapes import IN_URDF, Mesh, Shape, Sphere, UnknownShape
from ulna.description.xml import Reader
from ulna.errors import DescriptionError, cited
from ulna.kernels.layout import LARGEST

OLDEST, NEWEST = (1, 4), (1, 12)
FRAMES_SINCE, FORMATS_SINCE, MIMIC_SINCE, JOINT_AXES_SINCE = (1, 7), (1, 9), (1, 11), (1, 5)
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_NAMED = {"joint", "link", "frame", "model", "visual", "collision", "include", "world"}
_BOOLEANS = {"true": True, "1": True, "false": False, "0": False}
_LONGEST_NAME, _MAX_UNKNOWN = 1000, 1000


class Elements(Reader):
    """Reads the elements of one document: the robot's, or an included one."""

    def __init__(self, source: str, root: etree._Element, robot: Collected, included: Included | None = None) -> None:
        super().__init__(source)
        self.root, self.robot, self.included = root, robot, included
        self.version = self.known_version()
        n_unknown = 0
        for part in unread_parts(root):
            if part.message:
                self.leave_out(part.element, part.message)
                n_unknown += 1
                if n_unknown > _MAX_UNKNOWN:
                    raise self.fail(part.element, f"has more than {_MAX_UNKNOWN} elements and attributes that are not known")
            else:
                robot.unread[part.what] += 1

    def known_version(self) -> tuple[int, int]:
        """The version of a document; raises an error for an unsupported one."""
        stated = re.fullmatch(r"([0-9]{1,4})\.([0-9]{1,4})", self.root.get("version", ""))
        if self.root.tag != "sdf" or stated is None:
            root = f"<{self.root.tag} version={cited(self.root.get('version'))}>"
            raise self.fail(self.root, f'{root} is not a supported SDF: <sdf version="1.9"> is expected, or another version')
        version = int(stated[1]), int(stated[2])
        if not OLDEST <= version <= NEWEST:
            oldest, newest = _words(OLDEST), _words(NEWEST)
            message = f"is SDF {stated[0]}; versions {oldest} to {newest} are read, and others may mean something else"
            raise self.fail(self.root, message)
        return version

    def require_version(self, version: tuple[int, int], element: etree._Element, what: str) -> None:
        """Refuse a feature that is newer than the document's version, and that other programs ignore."""
        if self.version < version:
            advice = f'if this is intended, write <sdf version="{_words(version)}">'
            message = f"{what} is of SDF {_words(version)}, and this document is of {_words(self.version)}: {advice}"
            raise self.place(element).fail(message)

    def place(self, element: etree._Element) -> Place:
        """The joint, link, frame or model that contains an element, or the document."""
        for one in (element, *element.iterancestors()):
            if one.tag in _NAMED:
                name = (one.findtext("uri") or "").strip() if one.tag == "include" else one.get("name", "")
                return Place(self.source, element.sourceline, f"{one.tag} {name!r}")
        return Place(self.source, element.sourceline, "document")

    def leave_out(self, element: etree._Element, message: str, *, is_warned: bool = True) -> None:
        """Record a part that is not read; for an included file, its words contain the line."""
        where, line = self.place(element).words, element.sourceline
        if self.included is None:
            self.robot.left_out.append(LeftOut(where, message, line, is_warned))
        else:
            self.robot.left_out.append(LeftOut(f"{self.source}:{line}: {where}", message, is_warned=is_warned))

    def name(self, element: etree._Element, given: str | None = None) -> str:
        """The name of an element, or the one that an include gives it; raises an error for SDF's reserved names."""
        name = given or self.attribute(element, "name")
        if name == WORLD or (name.startswith("__") and name.endswith("__")) or len(name) > _LONGEST_NAME:
            message = f"is reserved by SDF, or longer than {_LONGEST_NAME} letters; give it another"
            raise self.fail(element, f"<{element.tag}>: the name {cited(name)} {message}")
        return name

    def words(self, element: etree._Element, tag: str) -> str:
        """The text of a child element; "" if it is missing."""
        child = self.only(element, tag)
        return "" if child is None else (child.text or "").strip()

    def needed(self, element: etree._Element, tag: str) -> str:
        """The text of a required child."""
        if not (words := self.words(element, tag)):
            raise self.place(element).fail(f"has no <{tag}>")
        return words

    def floats(self, element: etree._Element, count: int, low: float = -math.inf) -> tuple[float, ...]:
        """The text of an element as ``count`` finite numbers of at least ``low``."""
        return self.finite(element, element.text or "", count, low)

    def truth(self, element: etree._Element, words: str, what: str) -> bool:
        """The boolean value of a text; False if it is empty."""
        value = _BOOLEANS.get((words or "false").lower())
        if value is None:
            raise self.place(element).fail(f"{what} is {cited(words)}; true or false is expected")
        return value

    def is_true(self, element: etree._Element, tag: str) -> bool:
        """The boolean value of a child."""
        return self.truth(element, self.words(element, tag), f"<{tag}>")

    def pose_of(self, element: etree._Element) -> tuple[str, Array]:
        """The frame of an element's pose ("" for its default), and the pose."""
        child = self.only(element, "pose")
        if child is None:
            return "", np.eye(4)
        if child.get("frame"):
            advice = "save it as SDF 1.7 or later, with relative_to"
            raise self.place(child).fail(f"its pose has a frame, which SDF 1.6 and before do not define; {advice}")
        for key, version in (("relative_to", FRAMES_SINCE), ("rotation_format", FORMATS_SINCE), ("degrees", FORMATS_SINCE)):
            if child.get(key):
                self.require_version(version, child, key)
        return child.get("relative_to", ""), self.matrix(child)

    def matrix(self, child: etree._Element) -> Array:
        """The matrix of a ``<pose>``."""
        kind, place = child.get("rotation_format", "euler_rpy"), self.place(child)
        degrees = self.truth(child, child.get("degrees", ""), "degrees")
        if kind not in ("euler_rpy", "quat_xyzw"):
            raise place.fail(f"rotation_format {cited(kind)} is not known; there are euler_rpy and quat_xyzw")
        if not (child.text or "").strip():
            return np.eye(4)
        if kind == "euler_rpy":
            values = self.floats(child, 6)
            turn = {"rpy": np.radians(values[3:]) if degrees else values[3:]}
        else:
            *values, w = self.floats(child, 7)
            if degrees or max(map(abs, (*values[3:], w))) < 1e-12:
                raise place.fail("its pose is a quaternion with degrees, or of length 0, which is no orientation")
            turn = {"wxyz": (w, *values[3:])}
        if max(map(abs, values[:3])) > LARGEST:
            raise place.fail(f"its pose is beyond {LARGEST:g} m")
        return pose(values[:3], **turn)

    def link(self, element: etree._Element, scope: str) -> Link:
        """A link with its shapes."""
        key = scope + self.name(element)
        visuals, collisions = (tuple(self.bodies(element, tag, key, scope)) for tag in ("visual", "collision"))
        return Link(key, visuals, collisions, element.sourceline, self.inertia(element))

    def inertia(self, link: etree._Element) -> Inertia | None:
        """The inertia of a link, in its axes; None without one, or for a faulty one, with a note.

        A missing mass is 1 kg, a missing moment 1 kg m^2, as SDFormat defines.
        """
        try:
            inertial = self.only(link, "inertial")
            if inertial is None:
                return None
            if self.truth(inertial, inertial.get("auto", ""), "auto"):
                raise self.place(inertial).fail("auto, an inertia computed from shapes, is not supported")
            base, at = self.pose_of(inertial)
            if base:
                raise self.place(inertial).fail("its <pose> has relative_to, which SDFormat refuses")
            numbers = self.only(inertial, "inertia")
            moments = [self.given(numbers, key, float(key[1] == key[2])) for key in MOMENTS]
            return Inertia.stated(self.given(inertial, "mass", 1.0, 0.0), moments, at)
        except DescriptionError as error:
            message = f"{error.message}: this inertia is left out, so it has none"
            self.leave_out(link, message, is_warned=False)
            return None

    def given(self, element: etree._Element | None, tag: str, default: float, low: float = -math.inf) -> float:
        """The number in a child of an element; the default if either is missing."""
        child = None if element is None else self.only(element, tag)
        return default if child is None else self.floats(child, 1, low)[0]

    def bodies(self, link: etree._Element, tag: str, key: str, scope: str) -> Iterator[Body]:
        """The shapes of a link; faulty visuals are omitted, unknown collision shapes stay as ``UnknownShape``."""
        frames = self.robot.frames
        for element in link.iterfind(tag):
            try:
                base, at = self.pose_of(element)
                if base:
                    at = frames.between(key, frames.find(scope, base, self.place(element))) @ at
                shape = self.shape(self.child(element, "geometry"))
            except DescriptionError as error:
                if tag != "visual":
                    raise
                self.leave_out(element, f"{error.message}: this visual is left out, so it is not drawn")
                continue
            if isinstance(shape, UnknownShape):
                result = "it is not drawn" if tag == "visual" else "poses can be computed, collisions cannot"
                self.leave_out(element, f"its geometry is {shape.kind}, which is not known: {result}")
            if shape is not None and not (tag == "visual" and isinstance(shape, UnknownShape)):
                yield Body(element.get("name") or f"{link.get('name')}_{tag}", shape, at, self.color(element))

    def shape(self, geometry: etree._Element) -> Shape | None:
        """The shape of a geometry; None if it is stated to be empty."""
        shapes = [child for child in geometry.iterchildren(etree.Element) if etree.QName(child).namespace is None]
        if len(shapes) != 1:
            raise self.place(geometry).fail(f"its <geometry> has {len(shapes)} shapes; one is expected")
        one = shapes[0]
        sizes = {tag: child for tag in ("size", "radius", "length", "radii") if (child := self.only(one, tag)) is not None}
        kind = IN_URDF.get(str(one.tag))  # SDF has the names of URDF
        if kind is not None or one.tag == "ellipsoid":
            needed = ("radii",) if kind is None else kind.urdf
            missing = next((tag for tag in needed if tag not in sizes), None)
            if missing is not None:
                raise self.place(one).fail(f"its <{one.tag}> has no <{missing}>")
            lengths = [self.floats(sizes[tag], 3 if tag in ("size", "radii") else 1, 0.0) for tag in needed]
            if kind is not None:
                return kind.shape(*(each if len(each) == 3 else each[0] for each in lengths))
            if len(set(lengths[0])) == 1:
                return Sphere(lengths[0][0])
        if one.tag == "mesh" and one.find("submesh") is None:
            return self.mesh(one)
        name = f"<{one.tag}>" if one.tag != "mesh" else "a <submesh>"
        return None if one.tag == "empty" else UnknownShape(name)

    def mesh(self, element: etree._Element) -> Mesh:
        """A mesh, with its address as seen from the document."""
        uri, scale = self.needed(element, "uri"), self.only(element, "scale")
        x, y, z = (1.0, 1.0, 1.0) if scale is None else self.floats(scale, 3)
        return Mesh(uri if self.included is None else self.included.address(uri), (x, y, z))

    def color(self, body: etree._Element) -> tuple[float, float, float, float] | None:
        """The diffuse color of a body; None with a note if it is faulty."""
        diffuse = body.find("material/diffuse")
        if diffuse is None:
            return None
        try:
            values = self.floats(diffuse, 3 if len((diffuse.text or "").split()) == 3 else 4)
        except DescriptionError as error:
            self.leave_out(body, f"{error.message}: this color is left out")
            return None
        red, green, blue, alpha = (*values, 1.0)[:4]
        return red, green, blue, alpha


def _words(version: tuple[int, int]) -> str:
    return ".".join(map(str, version))
