"""Reads SDF (sdformat.org), the models of Gazebo, with frames as SDFormat 1.7 and later resolve them."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from lxml import etree

from ulna.description.document import Document
from ulna.description.robot_description import Description, LeftOut
from ulna.description.sdf.collected import Collected
from ulna.description.sdf.elements import FRAMES_SINCE
from ulna.description.sdf.files import MAX_INCLUDES, ModelFiles
from ulna.description.sdf.frames import MODEL, OUTSIDE, WORLD, Array, Frame
from ulna.description.sdf.joints import Joints
from ulna.description.xml import without_namespace
from ulna.errors import DescriptionError, FileError, listed

_MAX_LEVELS, _LONGEST_SCOPE = 32, 1000  # nested models, and letters of their names together
_PARTS = ("link", "joint", "frame", "model", "include")
_ALONE = "save the robot's model in a separate file"


def read_sdf(document: Document) -> Description:
    """The description in an SDF document: its model, or the only model of its world that is not static.

    A frame is a link without shapes. Parts of a nested model ``a`` are called ``a::name``. The world is the root in three cases:
    a joint is attached to it, the model is static, or the root link is not at the world's origin. A link without shapes precedes
    a joint whose axis misses its child's origin.

    Raises:
        DescriptionError: Its version is not supported, it has several models, or a joint with several degrees of freedom.
        FileError: An included model is missing, or may not be read.
    """
    is_text = document.folder is None and document.source == "URDF text"
    source = "SDF text" if is_text else document.source
    root, robot = without_namespace(document.root), Collected(ModelFiles(document))
    if document.parsed.mended:
        message = f"is not well-formed XML, as other programs may say: {document.parsed.mended}"
        robot.left_out.append(LeftOut("document", message, root.sourceline, is_warned=False))
    name = _Models(source, root, robot).robot_model()
    links, joints = robot.finished()
    notes = (LeftOut("document", f"{n} {what} not used", is_warned=False, is_note=True) for what, n in robot.unread.items())
    return Description(
        name=name,
        links=tuple(links),
        joints=tuple(joints),
        source=source,
        folder=document.folder,
        package_dirs=document.package_dirs,
        left_out=(*robot.left_out, *notes),
    )


class _Overrides(NamedTuple):
    """The values of an ``<include>`` that override those of its model; None if not given."""

    name: str | None = None
    pose: tuple[str, Array] | None = None
    placement: str | None = None
    is_static: bool | None = None


class _WorldModel(NamedTuple):
    """A model of a world: its element, the function that collects it, and whether it is static."""

    element: etree._Element
    collect: Callable[[], str]
    is_static: bool


class _Models(Joints):
    """Collects the models of one document, or of an included one."""

    def robot_model(self) -> str:
        """Collect the model that is the robot; returns its name."""
        holders = [child for child in self.root if child.tag in ("model", "world")]
        if len(holders) != 1:
            names = listed([self.place(child).words for child in holders]) or "none"
            raise self.fail(self.root, f"one <model> or one <world> is expected, and there is {names}; {_ALONE}")
        return self.model(holders[0], "", _Overrides()) if holders[0].tag == "model" else self.world_model(holders[0])

    def world_model(self, world: etree._Element) -> str:
        """Collect the model of a world that is not static, or its only one; the others are omitted."""
        if (tie := world.find("joint")) is not None:
            raise self.place(tie).fail(f"is a joint of the world, which connects models; {_ALONE}")
        found, fault = self.models_of(world)
        moving = [one for one in found if not one.is_static]
        if fault is not None and not moving:
            raise fault
        candidates = found if len(found) == 1 else moving
        if len(candidates) != 1:
            names = listed([self.place(element).words for element, *_ in candidates or found]) or "none"
            raise self.place(world).fail(f"one model that is not static is expected, and there is {names}; {_ALONE}")
        chosen = candidates[0]
        for other in (one for one in found if one is not chosen):
            self.leave_out(
                other.element, "is static and not the robot, so it is left out; ulna.World contains the objects around a robot"
            )
        for frame in world.iterfind("frame"):
            self.frame(frame, OUTSIDE)
        return chosen.collect()

    def models_of(self, world: etree._Element) -> tuple[list[_WorldModel], FileError | DescriptionError | None]:
        """The models of a world, and the error of the last omitted include."""
        found: list[_WorldModel] = []
        fault = None
        for element in (child for child in world if child.tag in ("model", "include")):
            try:
                reader, model, given = self.opened(element)
            except (FileError, DescriptionError) as error:
                if element.tag == "model" or self.robot.files.n_includes > MAX_INCLUDES:
                    raise
                self.leave_out(element, f"is left out, as it has no model that can be read: {error}")
                fault = error
            else:
                found.append(_WorldModel(element, partial(reader.model, model, "", given), reader.is_static(model, given)))
        return found, fault

    def is_static(self, model: etree._Element, given: _Overrides) -> bool:
        """Whether a model does not move."""
        return self.is_true(model, "static") if given.is_static is None else given.is_static

    def model(self, model: etree._Element, scope: str, given: _Overrides, outer: str = OUTSIDE) -> str:
        """Collect a model in the scope ``outer``; returns its name. Its frames are named ``scope`` plus their name."""
        name, place, robot = self.name(model, given.name), self.place(model), self.robot
        if scope.count("::") > _MAX_LEVELS or len(scope) > _LONGEST_SCOPE:
            raise place.fail(f"is in more than {_MAX_LEVELS} nested models, or their names are too long")
        canonical, placement = model.get("canonical_link", ""), model.get("placement_frame", "")
        if canonical or placement:
            self.require_version(FRAMES_SINCE, model, "canonical_link" if canonical else "placement_frame")
        parts = sorted((child for child in model if child.tag in _PARTS), key=lambda child: child.tag != "link")
        bodies = [child for child in parts if child.tag == "link"] or [c for c in parts if c.tag in ("model", "include")]
        if not bodies:
            raise place.fail("has no links")
        is_static = self.is_static(model, given)
        if not scope:
            robot.is_static = is_static
        elif is_static and not robot.is_static:
            raise place.fail("is static in a model that is not, so it is not part of a tree of joints")
        base, T = self.pose_of(model) if given.pose is None else given.pose
        base = base or (MODEL if scope else WORLD)
        frame = Frame("model", place, outer, base, T, canonical or self.name_of(bodies[0]))
        robot.frames.add(scope + MODEL, frame)
        for part in parts:
            self.part(part, scope)
        if placement := given.placement or placement:
            robot.frames.put(scope + MODEL, placement)
        return name

    def part(self, element: etree._Element, scope: str) -> None:
        """Collect a part of a model."""
        match element.tag:
            case "model" | "include":
                reader, model, given = self.opened(element)
                reader.model(model, f"{scope}{reader.name(model, given.name)}::", given, scope)
            case "frame" if self.version < FRAMES_SINCE:
                self.leave_out(element, "a frame of SDF 1.6 and before is not used")
            case "frame":
                self.frame(element, scope)
            case _:
                self.link_or_joint(element, scope)

    def link_or_joint(self, element: etree._Element, scope: str) -> None:
        """Collect a link or a joint, which is read once all frames are known."""
        robot, name, (base, T) = self.robot, self.name(element), self.pose_of(element)
        key, place = scope + name, self.place(element)
        if element.tag == "link":
            robot.frames.add(key, Frame("link", place, scope, base or MODEL, T, name))
            robot.links.append(partial(self.link, element, scope))
            return
        if key in robot.joints:
            raise place.fail("is defined twice")
        if self.joint_type(element) != "fixed":
            robot.moving.append(key)
        child = self.needed(element, "child")
        frame_key = f"{scope}joint {name}" if self.version < FRAMES_SINCE and key in robot.frames.frames else key
        robot.frames.add(frame_key, Frame("joint", place, scope, base or child, T, child))
        robot.joints[key] = partial(self.joint, element, scope, frame_key)

    def frame(self, element: etree._Element, scope: str) -> None:
        """Collect a frame of a model, or of the world."""
        self.require_version(FRAMES_SINCE, element, "<frame>")
        base, T = self.pose_of(element)
        to = element.get("attached_to") or (WORLD if scope == OUTSIDE else MODEL)
        self.robot.frames.add(scope + self.name(element), Frame("frame", self.place(element), scope, base or to, T, to))

    def name_of(self, element: etree._Element) -> str:
        """The name of a link, a model, or an included model."""
        if element.tag == "link":
            return self.name(element)
        reader, model, given = self.opened(element)
        return reader.name(model, given.name)

    def opened(self, element: etree._Element) -> tuple["_Models", etree._Element, _Overrides]:
        """The model of a ``<model>`` or an ``<include>``, its reader, and the include's overrides."""
        if element.tag == "model":
            return self, element, _Overrides()
        if element not in self.robot.opened:
            self.robot.opened[element] = self.included_model(element)
        return self.robot.opened[element]

    def included_model(self, include: etree._Element) -> tuple["_Models", etree._Element, _Overrides]:
        """The model of an ``<include>``."""
        place, placement = self.place(include), self.words(include, "placement_frame")
        if self.truth(include, include.get("merge", ""), "merge"):
            raise place.fail("merge is not read; include the model without it")
        if any(etree.QName(child).localname == "params" for child in include.iterchildren(etree.Element)):
            raise place.fail("has parameters, which change the model; they are not read")
        if placement:
            self.require_version(FRAMES_SINCE, include, "<placement_frame>")
            if include.find("pose") is None:
                raise place.fail("has a <placement_frame>, which needs a <pose>")
        given = _Overrides(
            self.words(include, "name") or None,
            None if include.find("pose") is None else self.pose_of(include),
            placement or None,
            None if include.find("static") is None else self.is_true(include, "static"),
        )
        included = self.robot.files.included(self.needed(include, "uri"), self.included, place)
        reader = _Models(included.path.name, included.root, self.robot, included)
        models = [child for child in included.root if child.tag in ("model", "world")]
        if len(models) != 1 or models[0].tag != "model":
            raise reader.fail(included.root, "one <model> is expected in a file that is included, and nothing else")
        return reader, models[0], given
