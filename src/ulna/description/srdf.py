"""Reads SRDF (wiki.ros.org/srdf); invalid elements are refused with file and line.

Elements of other programs (grippers, rotors, feet, collision spheres, properties of joints) are ignored.
"""

import math
from collections.abc import Iterable

from lxml import etree

from ulna.description.document import Document
from ulna.description.semantic import DisabledCollision, EndEffector, Group, GroupState, Srdf, VirtualJoint
from ulna.description.xml import Reader, without_namespace
from ulna.errors import cited, did_you_mean

_READ = {
    "robot": (
        "group",
        "end_effector",
        "group_state",
        "disable_collisions",
        "virtual_joint",
        "passive_joint",
        "disable_default_collisions",
        "enable_collisions",
    ),
    "group": ("link", "joint", "chain", "group"),
    "group_state": ("joint",),
}
_OTHERS = {"foot", "gripper", "joint_property", "link_sphere_approximation", "rotor", "rotor_params", "specificities"}
_MAX_GROUPS = 2000  # groups, chains and states: resolving them takes their number times that of the joints


def read_srdf(document: Document) -> Srdf:
    """The semantic description in an SRDF document, as written: names are not looked up."""
    return _Reader(document.source).srdf(without_namespace(document.root))


class _Reader(Reader):
    """Reads one SRDF document."""

    def srdf(self, root: etree._Element) -> Srdf:
        if root.tag != "robot":
            raise self.fail(root, f"the root element is <{root.tag}>, not <robot>: this is not an SRDF")
        if root.find("link") is not None:
            raise self.fail(root.findall("link")[0], "defines a link: this is a URDF, where an SRDF is expected")
        for path in ("group", "group/chain", "group_state"):
            if len(root.findall(path)) > _MAX_GROUPS:
                raise self.fail(root, f"has more than {_MAX_GROUPS} <{path.rpartition('/')[2]}>")
        return Srdf(
            name=root.get("name", ""),
            groups=self.unique([self.group(element) for element in root.iterfind("group")], root, "group"),
            end_effectors=self.unique([self.end_effector(e) for e in root.iterfind("end_effector")], root, "end_effector"),
            states=self.unique([self.state(element) for element in root.iterfind("group_state")], root, "group_state"),
            disabled_collisions=tuple(self.disabled(element) for element in root.iterfind("disable_collisions")),
            virtual_joints=tuple(self.virtual_joint(element) for element in root.iterfind("virtual_joint")),
            passive_joints=self.names(root, "passive_joint"),
            unchecked_links=tuple(self.attribute(e, "link") for e in root.iterfind("disable_default_collisions")),
            enabled_collisions=tuple(self.pair(element) for element in root.iterfind("enable_collisions")),
            source=self.source,
            warnings=tuple(self.unread(root)),
        )

    def unread(self, root: etree._Element) -> Iterable[str]:
        """A sentence about each unknown element, such as a misspelt one, which may change the checked pairs."""
        for parent in (root, *root.iterfind("group"), *root.iterfind("group_state")):
            read = _READ[str(parent.tag)]
            for child in parent.iterchildren(etree.Element):
                if child.tag not in read and child.tag not in _OTHERS and etree.QName(child).namespace is None:
                    near = did_you_mean(str(child.tag), read)
                    yield str(self.fail(child, f"<{child.tag}> in <{parent.tag}> is not known, and left out{near}"))

    def unique(self, items: list, root: etree._Element, tag: str) -> tuple:
        """The items; raises an error if two have the same name."""
        seen: dict[str, int | None] = {}
        for item, element in zip(items, root.iterfind(tag), strict=True):
            key = getattr(item, "key", item.name)
            if key in seen:
                raise self.fail(element, f"<{tag}> {key!r} is defined twice, first in line {seen[key]}")
            seen[key] = element.sourceline
        return tuple(items)

    def names(self, element: etree._Element, tag: str) -> tuple[str, ...]:
        return tuple(self.attribute(child, "name") for child in element.iterfind(tag))

    def group(self, element: etree._Element) -> Group:
        chains: Iterable[etree._Element] = element.iterfind("chain")
        return Group(
            name=self.attribute(element, "name"),
            links=self.names(element, "link"),
            joints=self.names(element, "joint"),
            chains=tuple((self.attribute(chain, "base_link"), self.attribute(chain, "tip_link")) for chain in chains),
            subgroups=self.names(element, "group"),
            line=element.sourceline,
        )

    def end_effector(self, element: etree._Element) -> EndEffector:
        name, link, group = (self.attribute(element, key) for key in ("name", "parent_link", "group"))
        return EndEffector(name, link, group, element.get("parent_group") or None, element.sourceline)

    def state(self, element: etree._Element) -> GroupState:
        values: dict[str, tuple[float, ...]] = {}
        for child in element.iterfind("joint"):
            name = self.attribute(child, "name")
            if name in values:
                raise self.fail(child, f"joint {name!r} is given two values in one <group_state>")
            values[name] = self.value(child)
        name, group = self.attribute(element, "name"), element.get("group") or None
        return GroupState(name, group, tuple(values.items()), element.sourceline)

    def value(self, element: etree._Element) -> tuple[float, ...]:
        values = self.numbers(element, "value")
        if not values or not all(math.isfinite(value) for value in values):
            raise self.fail(element, f"<joint> value={cited(element.get('value'))}: finite numbers expected")
        return values

    def pair(self, element: etree._Element) -> tuple[str, str]:
        return self.attribute(element, "link1"), self.attribute(element, "link2")

    def disabled(self, element: etree._Element) -> DisabledCollision:
        return DisabledCollision(*self.pair(element), element.get("reason", ""), element.sourceline)

    def virtual_joint(self, element: etree._Element) -> VirtualJoint:
        name, kind, frame, link = (self.attribute(element, key) for key in ("name", "type", "parent_frame", "child_link"))
        return VirtualJoint(name, kind, frame, link, element.sourceline)
