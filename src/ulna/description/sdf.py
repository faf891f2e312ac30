"""Reads SDF (sdformat.org), the models of Gazebo: frames as SDFormat 1.7 and later resolve them, older ones where that is the same."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from lxml import etree

from ulna.description.document import Document
from ulna.description.pose import inverse, pose
from ulna.description.robot_description import Body, Description, Joint, JointType, LeftOut, Limits, Link, Mimic
from ulna.description.sdf_files import Included, ModelFiles
from ulna.description.sdf_frames import MODEL, OUTSIDE, WORLD, Array, Frame, Frames, Place
from ulna.description.sdf_unread import unread_parts
from ulna.description.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, UnknownShape
from ulna.description.xml import Reader, without_namespace
from ulna.errors import DescriptionError, FileError, cited, did_you_mean, listed
from ulna.kernels.layout import LARGEST

_OLDEST, _NEWEST = (1, 4), (1, 12)
_FRAMES_SINCE, _FORMATS_SINCE, _MIMIC_SINCE, _JOINT_AXES_SINCE = (1, 7), (1, 9), (1, 11), (1, 5)
_NONE = 1e16  # a limit of this size or more is none
_MAX_LEVELS = 32  # of models in models
_ROUNDING = 1e-13  # m: an axis this near to the origin of its link goes through it
_TYPES = {"revolute", "continuous", "prismatic", "fixed"}
_COUPLED = {
    "screw": "turns and slides at once",
    "universal": "has two axes",
    "revolute2": "has two axes",
    "gearbox": "ties three links",
    "ball": "has no axis",
}
_Z = (0.0, 0.0, 1.0)


def read_sdf(document: Document) -> Description:
    """The description in an SDF document: its model, or the model of its world that is not static.

    A link is a link, and a frame is a link without shapes. The world is the root if a joint is attached to it, or if
    the model's pose and that of its first link are not those of the world. What is in a model ``a`` of the model is called
    ``a::name``. A joint whose axis does not go through the origin of its child has a link without shapes before it.

    Raises:
        DescriptionError: It is of a version that is not read, or has what is no tree of joints, or several models; by name.
        FileError: A model that it includes is not there, or may not be read.
    """
    source = document.source if document.folder is not None or not document.source.startswith("URDF") else "SDF text"
    root, robot = without_namespace(document.root), _Robot(ModelFiles(document))
    reader = _Reader(source, root, robot)
    if document.parsed.mended:
        message = f"is not well-formed XML, as other programs may say: {document.parsed.mended}"
        robot.left_out.append(LeftOut("document", message, root.sourceline, is_warned=False))
    name = reader.robot_model()
    links, joints = robot.finished()
    return Description(
        name=name,
        links=tuple(links),
        joints=tuple(joints),
        source=source,
        folder=document.folder,
        package_dirs=document.package_dirs,
        left_out=(*robot.left_out, *robot.notes()),
    )


class _Given(NamedTuple):
    """What an ``<include>`` says of a model in place of the model itself; None where it says nothing."""

    name: str | None = None
    pose: tuple[str, Array] | None = None
    placement: str | None = None
    is_static: bool | None = None


@dataclass
class _Robot:
    """What is collected from a document and the models that it includes."""

    files: ModelFiles
    frames: Frames = field(default_factory=Frames)
    links: list[tuple["_Reader", etree._Element, str]] = field(default_factory=list)
    joints: list[tuple["_Reader", etree._Element, str, str]] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    unread: dict[str, int] = field(default_factory=dict)
    is_static: bool = False

    def notes(self) -> Iterator[LeftOut]:
        """What no pose depends on."""
        for what, count in self.unread.items():
            yield LeftOut("document", f"{count} {what} not used", is_warned=False, is_note=True)

    def finished(self) -> tuple[list[Link], list[Joint]]:
        """The links and joints, where all frames are known."""
        links = [reader.link(element, scope) for reader, element, scope in self.links]
        self.names = {link.name for link in links}
        self.joint_names = {scope + element.get("name", "") for _, element, scope, _ in self.joints}
        joints: list[Joint] = []
        if not self.is_static:
            for reader, element, scope, key in self.joints:
                some, more = reader.joint(element, scope, key)
                joints += some
                links += more
        elif moving := [scope + e.get("name", "") for _, e, scope, _ in self.joints if e.get("type") != "fixed"]:
            message = f"is static, so its joints do not move: {listed(moving)}"
            self.left_out.append(LeftOut("model", message, self.frames.frames[MODEL].place.line))
        carried = {joint.child for joint in joints}
        roots = [link for link in links if link.name not in carried]
        on_world = self.is_static or any(joint.parent == WORLD for joint in joints)
        alone = len(roots) == 1 and not np.array_equal(self.frames.pose_of(roots[0].name), np.eye(4))
        if self.is_static or (alone and not on_world):
            joints = [self.fixed(WORLD, link.name, link.line) for link in roots] + joints
            on_world = True
        for key, frame in self.frames.frames.items():
            if frame.kind == "frame" and not key.startswith(OUTSIDE):
                parent = self.frames.find(frame.scope, frame.attached_to, frame.place)
                if self.frames.frames[parent].kind not in ("link", "frame"):
                    parent = self.frames.body_of(parent)
                joints.append(self.fixed(parent, key, frame.place.line))
                links.append(Link(key, line=frame.place.line))
        return ([Link(WORLD)] if on_world else []) + links, joints

    def fixed(self, parent: str, child: str, line: int | None, T: Array | None = None) -> Joint:
        """A fixed joint that is not in the document."""
        name = self.unused(f"{child}_fixed", self.joint_names)
        T = self.frames.between(parent, child) if T is None else T
        return Joint(name, JointType.FIXED, parent, child, T, np.array(_Z), line=line)

    def unused(self, name: str, names: set[str]) -> str:
        """A name that is not among others, and now is."""
        while name in names or name in self.frames.frames:
            name += "_"
        names.add(name)
        return name


class _Reader(Reader):
    """Reads one SDF document: that of the model, or of one that it includes."""

    def __init__(self, source: str, root: etree._Element, robot: _Robot, included: Included | None = None) -> None:
        super().__init__(source)
        self.root, self.shared, self.included = root, robot, included
        self.kept: dict[etree._Element, tuple[_Reader, etree._Element, _Given]] = {}
        self.version = self.known_version(root)
        for part in unread_parts(root):
            if part.message:
                self.leave_out(part.element, part.message)
            else:
                robot.unread[part.what] = robot.unread.get(part.what, 0) + 1

    def leave_out(self, element: etree._Element, message: str) -> None:
        """Note a part that is not read. The line of one in an included file is in its words."""
        where, line = self.place(element).words, element.sourceline
        if self.included is None:
            self.shared.left_out.append(LeftOut(where, message, line))
        else:
            self.shared.left_out.append(LeftOut(f"{self.source}:{line}: {where}", message))

    def place(self, element: etree._Element) -> Place:
        """The joint, link, frame or model that an element belongs to, or the document."""
        words = "document"
        for one in (element, *element.iterancestors()):
            if one.tag in ("joint", "link", "frame", "model", "include", "visual", "collision"):
                words = f"{one.tag} {one.get('name') or (one.findtext('uri') or '').strip()!r}"
                break
        return Place(self.source, element.sourceline, words)

    def known_version(self, root: etree._Element) -> tuple[int, int]:
        stated = re.fullmatch(r"([0-9]{1,4})\.([0-9]{1,4})", root.get("version", ""))
        if root.tag != "sdf" or stated is None:
            raise self.fail(
                root, f'<{root.tag} version={cited(root.get("version"))}>: <sdf version="1.9"> is expected, or another'
            )
        version = int(stated[1]), int(stated[2])
        if not _OLDEST <= version <= _NEWEST:
            oldest, newest = (".".join(map(str, each)) for each in (_OLDEST, _NEWEST))
            message = f"is SDF {root.get('version')}; versions {oldest} to {newest} are read"
            raise self.fail(root, f"{message}, and others mean something else by the same words")
        return version

    def since(self, version: tuple[int, int], element: etree._Element, what: str) -> None:
        """Refuse what a document's version does not have, and other programs ignore."""
        if self.version < version:
            since, stated = ".".join(map(str, version)), self.root.get("version")
            message = f"{what} is of SDF {since}, and this document is of {stated}, where it means nothing"
            raise self.fail(element, f'{self.place(element).words}: {message}; state <sdf version="{since}"> if it is meant')

    # Numbers and words, which SDF has as texts of elements.

    def words(self, element: etree._Element, tag: str, default: str = "") -> str:
        """The text of a child, without blanks around it."""
        child = self.only(element, tag)
        return default if child is None else (child.text or "").strip() or default

    def needed(self, element: etree._Element, tag: str) -> str:
        """The text of a child that must be there."""
        words = self.words(element, tag)
        if not words:
            raise self.fail(element, f"{self.place(element).words} has no <{tag}>")
        return words

    def floats(self, element: etree._Element, count: int, low: float = -math.inf) -> tuple[float, ...]:
        """The text of an element as so many finite numbers of at least ``low``."""
        return self.finite(element, element.text or "", count, low)

    def size(self, shape: etree._Element, tag: str, count: int = 1) -> tuple[float, ...]:
        """A length of a shape, or several."""
        return self.floats(self.child(shape, tag), count, low=0.0)

    def is_true(self, element: etree._Element, tag: str) -> bool:
        words = self.words(element, tag, "false").lower()
        if words not in ("true", "false", "1", "0"):
            raise self.fail(element, f"<{tag}> of {self.place(element).words} is {cited(words)}; true or false is expected")
        return words in ("true", "1")

    def pose_of(self, element: etree._Element) -> tuple[str, Array]:
        """What the pose of an element is relative to ("" by default), and the pose."""
        child = self.only(element, "pose")
        if child is None:
            return "", np.eye(4)
        if child.get("frame"):
            advice = "save it as SDF 1.7 or later with relative_to"
            raise self.fail(
                child, f"{self.place(element).words}: its pose has a frame, which SDF 1.5 and 1.6 did not define; {advice}"
            )
        base = child.get("relative_to", "")
        if base:
            self.since(_FRAMES_SINCE, child, "relative_to")
        for key in ("rotation_format", "degrees"):
            if key in child.attrib:
                self.since(_FORMATS_SINCE, child, key)
        return base, self.matrix(child)

    def matrix(self, child: etree._Element) -> Array:
        kind, degrees = child.get("rotation_format", "euler_rpy"), child.get("degrees", "false").lower()
        who = self.place(child).words
        if kind not in ("euler_rpy", "quat_xyzw") or degrees not in ("true", "false", "1", "0"):
            raise self.fail(child, f"{who}: rotation_format {cited(kind)} and degrees {cited(degrees)} of its pose are not known")
        if not (child.text or "").strip():
            return np.eye(4)
        if kind == "quat_xyzw":
            *xyz, x, y, z, w = self.floats(child, 7)
            if degrees in ("true", "1") or max(map(abs, (x, y, z, w))) < 1e-12:
                raise self.fail(
                    child, f"{who}: its pose has degrees with a quaternion, or one of length 0, which is no orientation"
                )
            T = pose(xyz, wxyz=(w, x, y, z))
        else:
            *xyz, roll, pitch, yaw = self.floats(child, 6)
            rpy = np.array([roll, pitch, yaw])
            T = pose(xyz, np.radians(rpy) if degrees in ("true", "1") else rpy)
        if max(map(abs, xyz)) > LARGEST:
            raise self.fail(child, f"{who}: its pose is beyond {LARGEST:g} m")
        return T

    # Models.

    def robot_model(self) -> str:
        """Collect the model that is the robot. Returns its name."""
        holders = [child for child in self.root if child.tag in ("model", "world")]
        if len(holders) != 1:
            names = listed([f"{child.tag} {child.get('name', '')!r}" for child in holders]) or "none"
            raise self.fail(
                self.root, f"one <model> or one <world> is expected, not {names}; save the robot's model in a file of its own"
            )
        if holders[0].tag == "model":
            return self.model(holders[0], "", _Given())
        return self.world_model(holders[0])

    def world_model(self, world: etree._Element) -> str:
        """Collect the model of a world that is not static, or the only one; the others are left out."""
        for frame in world.iterfind("frame"):
            self.frame(frame, OUTSIDE)
        if (tie := world.find("joint")) is not None:
            raise self.fail(tie, f"joint {tie.get('name')!r} of the world ties models together; join them in one <model>")
        found: list[tuple[etree._Element, Callable[[], str], bool]] = []
        elements = [child for child in world if child.tag in ("model", "include")]
        for element in elements:
            if element.tag == "model":
                found.append(
                    (element, lambda element=element: self.model(element, "", _Given()), self.is_true(element, "static"))
                )
                continue
            try:
                reader, model, given = self.opened(element)
            except (FileError, DescriptionError) as error:
                if len(elements) == 1:
                    raise
                self.leave_out(element, f"is left out, as it is no model that can be read: {error}")
            else:
                static = reader.is_true(model, "static") if given.is_static is None else given.is_static
                found.append((element, lambda args=(reader, model, given): args[0].model(args[1], "", args[2]), static))
        moving = [one for one in found if not one[2]] if len(found) > 1 else found
        if len(moving) != 1:
            names = listed([self.place(element).words for element, _, _ in moving or found]) or "none"
            message = f"the world has {len(moving or found)} models that may be the robot: {names}"
            raise self.fail(world, f"{message}; save the robot's model in a file of its own")
        for element, _, _ in found:
            if element is not moving[0][0]:
                self.leave_out(element, "is static, and not the robot: it is left out; a scene has the objects around a robot")
        return moving[0][1]()

    def model(self, model: etree._Element, scope: str, given: _Given, outer: str = OUTSIDE) -> str:
        """Collect a model in the scope ``outer``. Its frames are called ``scope`` and their name. Returns its name."""
        name = given.name or self.named(model)
        if scope.count("::") > _MAX_LEVELS:
            raise self.fail(model, f"model {name!r} is in more than {_MAX_LEVELS} models in one another")
        own = {key: model.get(key, "") for key in ("canonical_link", "placement_frame")}
        for key, value in own.items():
            if value:
                self.since(_FRAMES_SINCE, model, key)
        base, T = self.pose_of(model) if given.pose is None else given.pose
        children = [child for child in model if child.tag in ("link", "joint", "frame", "model", "include")]
        first = [child for child in children if child.tag == "link"] or [c for c in children if c.tag in ("model", "include")]
        canonical = own["canonical_link"] or (self.name_of(first[0]) if first else "")
        if not canonical:
            raise self.fail(model, f"model {name!r} has no links")
        is_static = self.is_true(model, "static") if given.is_static is None else given.is_static
        if not scope:
            self.shared.is_static = is_static
        elif is_static and not self.shared.is_static:
            raise self.fail(model, f"model {name!r} is static in a model that is not, so it is no part of a tree of joints")
        frame = Frame("model", self.place(model), outer, base or (MODEL if scope else WORLD), T, canonical)
        self.shared.frames.add(scope + MODEL, frame)
        for child in sorted(children, key=lambda child: child.tag != "link"):
            self.part(child, scope)
        placement = own["placement_frame"] if given.placement is None else given.placement
        if placement:
            self.shared.frames.put(scope + MODEL, placement)
        return name

    def part(self, element: etree._Element, scope: str) -> None:
        """Collect a part of a model."""
        robot = self.shared
        if element.tag == "frame":
            if self.version >= _FRAMES_SINCE:
                self.frame(element, scope)
            else:
                self.leave_out(element, "a frame of SDF 1.6 and before is not used")
            return
        if element.tag == "model":
            self.model(element, f"{scope}{self.named(element)}::", _Given(), scope)
            return
        if element.tag == "include":
            reader, model, given = self.opened(element)
            reader.model(model, f"{scope}{given.name or reader.named(model)}::", given, scope)
            return
        name, (base, T), key = self.named(element), self.pose_of(element), scope + self.named(element)
        if element.tag == "link":
            robot.frames.add(key, Frame("link", self.place(element), scope, base or MODEL, T, name))
            robot.links.append((self, element, scope))
            return
        if self.version < _FRAMES_SINCE and key in robot.frames.frames:
            key = f"{scope}joint {name}"  # a link may have that name too
        child = self.needed(element, "child")
        robot.frames.add(key, Frame("joint", self.place(element), scope, base or child, T, child))
        robot.joints.append((self, element, scope, key))

    def frame(self, element: etree._Element, scope: str) -> None:
        base, T = self.pose_of(element)
        self.since(_FRAMES_SINCE, element, "<frame>")
        attached_to = element.get("attached_to") or (WORLD if scope == OUTSIDE else MODEL)
        frame = Frame("frame", self.place(element), scope, base or attached_to, T, attached_to)
        self.shared.frames.add(scope + self.named(element), frame)

    def named(self, element: etree._Element) -> str:
        """The name of an element, which must not be one of SDF's own."""
        name = self.attribute(element, "name")
        if name == WORLD or (name.startswith("__") and name.endswith("__")):
            raise self.fail(element, f"<{element.tag}> has the name {name!r}, which SDF keeps for itself")
        return name

    def name_of(self, element: etree._Element) -> str:
        """The name of a link, a model, or an included model."""
        if element.tag != "include":
            return self.named(element)
        reader, model, given = self.opened(element)
        return given.name or reader.named(model)

    def opened(self, include: etree._Element) -> tuple["_Reader", etree._Element, _Given]:
        """The model of an ``<include>``, what reads it, and what the include says of it."""
        if include in self.kept:
            return self.kept[include]
        if include.get("merge", "false").lower() not in ("false", "0"):
            raise self.fail(include, f"{self.place(include).words}: merge is not read; include the model without it")
        for child in include:
            if etree.QName(child).localname == "params":
                raise self.fail(
                    child, f"{self.place(include).words}: <{child.prefix}:params>, which change the model, are not read"
                )
        uri = self.needed(include, "uri")
        included = self.shared.files.included(uri, self.included, self.place(include))
        reader = _Reader(included.path.name, included.root, self.shared, included)
        models = [child for child in included.root if child.tag in ("model", "world")]
        if len(models) != 1 or models[0].tag != "model":
            raise reader.fail(included.root, f"one <model> is expected in a file that is included, not {len(models)}")
        given_pose = None if include.find("pose") is None else self.pose_of(include)
        placement = self.words(include, "placement_frame") or None
        if placement is not None:
            self.since(_FRAMES_SINCE, include, "<placement_frame>")
            if given_pose is None:
                raise self.fail(include, f"{self.place(include).words} has a <placement_frame>, which needs a <pose>")
        is_static = None if include.find("static") is None else self.is_true(include, "static")
        name = self.words(include, "name") or None
        self.kept[include] = reader, models[0], _Given(name, given_pose, placement, is_static)
        return self.kept[include]

    # Links.

    def link(self, element: etree._Element, scope: str) -> Link:
        visuals = tuple(self.bodies(element, "visual", scope))
        return Link(
            scope + self.named(element), visuals, tuple(self.bodies(element, "collision", scope)), line=element.sourceline
        )

    def bodies(self, link: etree._Element, tag: str, scope: str) -> Iterator[Body]:
        """The shapes of a link. A faulty visual is left out; a collision shape that is not known stays, as such."""
        key = scope + self.named(link)
        for element in link.iterfind(tag):
            name = element.get("name") or f"{link.get('name')}_{tag}"
            try:
                base, T = self.pose_of(element)
                if base:
                    frames = self.shared.frames
                    T = frames.between(key, frames.find(scope, base, self.place(element))) @ T
                shape = self.shape(self.child(element, "geometry"))
                if shape is None:
                    continue
                if isinstance(shape, UnknownShape):
                    fault = "so it is not drawn" if tag == "visual" else "poses can be computed, collisions cannot"
                    self.leave_out(element, f"its geometry is {shape.kind}, which is not known: {fault}")
                if tag == "collision" or not isinstance(shape, UnknownShape):
                    yield Body(name, shape, T, self.color(element))
            except DescriptionError as error:
                if tag != "visual":
                    raise
                self.leave_out(element, f"{error.message}: this visual is left out, so it is not drawn")

    def shape(self, geometry: etree._Element) -> Shape | None:
        """The shape of a geometry; None if it is stated to be empty."""
        shapes = [child for child in geometry.iterchildren(etree.Element) if etree.QName(child).namespace is None]
        if len(shapes) != 1:
            raise self.fail(geometry, f"{self.place(geometry).words}: its <geometry> has {len(shapes)} shapes; one is expected")
        one = shapes[0]
        match one.tag:
            case "empty":
                return None
            case "box":
                x, y, z = self.size(one, "size", 3)
                return Box((x, y, z))
            case "sphere":
                return Sphere(*self.size(one, "radius"))
            case "cylinder" | "capsule":
                kind = Cylinder if one.tag == "cylinder" else Capsule
                return kind(*self.size(one, "radius"), *self.size(one, "length"))
            case "ellipsoid" if len(set(self.size(one, "radii", 3))) == 1:
                return Sphere(self.size(one, "radii", 3)[0])
            case "mesh" if one.find("submesh") is None:
                return self.mesh(one)
            case "mesh":
                return UnknownShape("<mesh> with a <submesh>")
        return UnknownShape(f"<{one.tag}>")

    def mesh(self, element: etree._Element) -> Mesh:
        uri, scale = self.needed(element, "uri"), self.only(element, "scale")
        x, y, z = (1.0, 1.0, 1.0) if scale is None else self.floats(scale, 3)
        return Mesh(uri if self.included is None else self.included.address(uri), (x, y, z))

    def color(self, body: etree._Element) -> tuple[float, float, float, float] | None:
        """The diffuse colour of a body; of a faulty one none, with a note."""
        diffuse = body.find("material/diffuse")
        if diffuse is None:
            return None
        try:
            values = self.floats(diffuse, 3 if len((diffuse.text or "").split()) == 3 else 4)
        except DescriptionError as error:
            self.leave_out(body, f"{error.message}: this colour is left out")
            return None
        red, green, blue, alpha = (*values, 1.0)[:4]
        return red, green, blue, alpha

    # Joints.

    def joint(self, element: etree._Element, scope: str, key: str) -> tuple[list[Joint], list[Link]]:
        """A joint, with a link without shapes and a fixed joint where its axis does not go through its child's origin."""
        robot, frames, place = self.shared, self.shared.frames, self.place(element)
        name, kind = scope + self.named(element), self.joint_type(element)
        parent_name = self.needed(element, "parent")
        parent = WORLD if parent_name == WORLD else frames.body_of(frames.find(scope, parent_name, place))
        child = frames.body_of(key)
        if parent == child:
            raise place.fail(f"joins link {child!r} to itself")
        if kind == JointType.FIXED:
            return [Joint(name, kind, parent, child, frames.between(parent, child), np.array(_Z), line=place.line)], []
        axis_element = self.only(element, "axis")
        if axis_element is None:
            raise place.fail(f"is {kind} and has no <axis>")
        axis, limits = self.axis(axis_element, scope, key), self.limits(axis_element, kind)
        mimic = self.mimic(axis_element, scope)
        if kind == JointType.REVOLUTE and math.isinf(limits.lower) and math.isinf(limits.upper):
            kind = JointType.CONTINUOUS
        T = frames.between(child, key)
        turned, offset = T[:3, :3] @ axis, T[:3, 3]
        if kind == JointType.PRISMATIC or np.abs(offset - (offset @ turned) * turned).max() <= _ROUNDING:
            origin = frames.between(parent, child)
            return [Joint(name, kind, parent, child, origin, turned, limits, mimic, place.line)], []
        between = robot.unused(f"{child}_at_{name}", robot.names)
        joint = Joint(name, kind, parent, between, frames.between(parent, key), axis, limits, mimic, place.line)
        return [joint, robot.fixed(between, child, place.line, inverse(T))], [Link(between, line=place.line)]

    def joint_type(self, element: etree._Element) -> JointType:
        value, place = self.attribute(element, "type"), self.place(element)
        if value in _COUPLED:
            raise place.fail(f"a {value} joint {_COUPLED[value]}, so no single number moves it: it is not read")
        if value not in _TYPES:
            raise place.fail(f"type {value!r} is not known{did_you_mean(value, _TYPES)}")
        if element.find("axis2") is not None:
            raise place.fail(f"is {value}, and has a second axis")
        return JointType(value)

    def axis(self, element: etree._Element, scope: str, key: str) -> Array:
        """The axis as a unit vector in the frame of the joint."""
        frames, place, xyz = self.shared.frames, self.place(element), self.only(element, "xyz")
        direction = np.array(_Z if xyz is None else self.floats(xyz, 3))
        direction = direction / (np.abs(direction).max() or 1.0)
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise place.fail("its axis has no direction")
        frame = "" if xyz is None else xyz.get("expressed_in", "")
        if frame and xyz is not None:
            self.since(_FRAMES_SINCE, xyz, "expressed_in")
        if self.version < _JOINT_AXES_SINCE or self.is_true(element, "use_parent_model_frame"):
            frame = MODEL
        if element.find("use_parent_model_frame") is not None and self.version >= _FRAMES_SINCE:
            raise place.fail('use_parent_model_frame is of SDF 1.5 and 1.6; expressed_in="__model__" says it')
        direction = direction / length
        return frames.between(key, frames.find(scope, frame, place))[:3, :3] @ direction if frame else direction

    def limits(self, axis: etree._Element, kind: JointType) -> Limits:
        place, limit = self.place(axis), self.only(axis, "limit")
        if limit is None:
            return Limits()
        lower, upper = self.bound(limit, "lower", -math.inf), self.bound(limit, "upper", math.inf)
        velocity, effort = (self.bound(limit, key, math.inf) for key in ("velocity", "effort"))
        velocity, effort = (math.inf if each < 0 else each for each in (velocity, effort))
        if kind == JointType.CONTINUOUS:
            if math.isfinite(upper - lower):
                self.leave_out(limit, "lower and upper of a continuous joint are not used; with type revolute they are")
            lower, upper = -math.inf, math.inf
        if lower > upper or lower == math.inf or upper == -math.inf:
            raise place.fail(f"lower limit {lower} is above upper limit {upper}, or leaves no range")
        return Limits(lower, upper, velocity, effort)

    def bound(self, limit: etree._Element, tag: str, default: float) -> float:
        """A limit; infinite where it is missing, or so large that SDF means none."""
        child = self.only(limit, tag)
        if child is None:
            return default
        values = self.parsed(child, child.text or "")
        if len(values) != 1 or math.isnan(values[0]):
            raise self.fail(child, f"{self.place(limit).words}: <{tag}> {cited(child.text)}: one number is expected")
        return math.copysign(math.inf, values[0]) if abs(values[0]) >= _NONE else values[0]

    def mimic(self, axis: etree._Element, scope: str) -> Mimic | None:
        """What a joint follows: multiplier * (position - reference) + offset."""
        child = self.only(axis, "mimic")
        if child is None:
            return None
        self.since(_MIMIC_SINCE, child, "<mimic>")
        if child.get("axis", "axis") != "axis":
            raise self.place(axis).fail("follows the second axis of a joint, which is not read")
        given = {tag: self.only(child, tag) for tag in ("multiplier", "offset", "reference")}
        values = {tag: None if one is None else self.floats(one, 1)[0] for tag, one in given.items()}
        multiplier = 1.0 if values["multiplier"] is None else values["multiplier"]
        offset = (values["offset"] or 0.0) - multiplier * (values["reference"] or 0.0)
        return Mimic(scope + self.attribute(child, "joint"), multiplier, offset)
