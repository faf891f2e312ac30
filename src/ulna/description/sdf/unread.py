"""Finds unread parts of an SDF document, and whether they may change a pose, a shape or a limit."""

from collections.abc import Iterator

from lxml import etree

from ulna.description.unread import Unread
from ulna.errors import did_you_mean

# For each element the children and the attributes that are read.
_CHILDREN = {
    "sdf": {"model", "world"},
    "world": {"model", "include", "frame", "joint"},
    "model": {"link", "joint", "frame", "model", "include", "pose", "static"},
    "include": {"uri", "name", "pose", "static", "placement_frame"},
    "link": {"pose", "inertial", "visual", "collision"},
    "inertial": {"pose", "mass", "inertia"},
    "inertia": {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"},
    "joint": {"pose", "parent", "child", "axis", "axis2"},
    "axis": {"xyz", "limit", "mimic", "dynamics", "use_parent_model_frame"},
    "dynamics": {"damping", "friction"},
    "limit": {"lower", "upper", "effort", "velocity"},
    "mimic": {"multiplier", "offset", "reference"},
    "frame": {"pose"},
    "visual": {"pose", "geometry", "material"},
    "collision": {"pose", "geometry"},
}
_ATTRIBUTES = {
    "sdf": {"version"},
    "world": {"name"},
    "model": {"name", "canonical_link", "placement_frame"},
    "include": {"merge"},
    "link": {"name"},
    "joint": {"name", "type"},
    "frame": {"name", "attached_to"},
    "visual": {"name"},
    "collision": {"name"},
    "pose": {"relative_to", "rotation_format", "degrees", "frame"},
    "xyz": {"expressed_in"},
    "mimic": {"joint", "axis"},
    **{tag: set() for tag in ("axis", "limit", "lower", "upper", "effort", "velocity", "parent", "child", "uri", "static")},
}
# Parts that change neither a pose nor a shape, a limit or a tree of joints.
_OTHERS = {
    "sdf": {"actor", "light", "plugin"},
    "model": {"allow_auto_disable", "enable_wind", "gripper", "plugin", "self_collide"},
    "include": {"plugin"},
    "link": {
        *(
            "audio_sink",
            "audio_source",
            "battery",
            "enable_wind",
            "gravity",
            "kinematic",
            "light",
            "must_be_base_link",
        ),
        *("particle_emitter", "plugin", "projector", "self_collide", "sensor", "velocity_decay"),
    },
    "joint": {"gearbox_ratio", "gearbox_reference_body", "physics", "plugin", "screw_thread_pitch", "sensor", "thread_pitch"},
    "axis": {"initial_position"},
    "dynamics": {"spring_reference", "spring_stiffness"},
    "inertial": {"density", "fluid_added_mass"},
    "limit": {"dissipation", "stiffness"},
    "visual": {"cast_shadows", "laser_retro", "meta", "plugin", "transparency", "visibility_flags"},
    "collision": {"auto_inertia_params", "density", "laser_retro", "max_contacts", "surface"},
}
_MAX_HINTS = 20
_WORLD = {"population", "actor"}  # of a world: these add moving things; the rest is scenery


class _Hints:
    """Suggests similar names for the first unknown names; the number is limited, since the search takes time."""

    def __init__(self) -> None:
        self.given: dict[str, str] = {}

    def of(self, name: str, known: set[str]) -> str:
        """The hint for a name; empty after too many names."""
        if name not in self.given and len(self.given) < _MAX_HINTS:
            self.given[name] = did_you_mean(name, sorted(known))
        return self.given.get(name, "")


def unread_parts(root: etree._Element) -> Iterator[Unread]:
    """The elements and attributes that are not read; those that may matter have a message."""
    waiting, hints = [root], _Hints()
    while waiting:
        element = waiting.pop()
        tag = str(element.tag)
        for key in map(str, element.attrib):
            if tag in _ATTRIBUTES and key not in _ATTRIBUTES[tag] and etree.QName(key).namespace is None:
                what = f"attribute {key!r} of <{tag}>"
                message = f"{what} is not known, and left out{hints.of(key, _ATTRIBUTES[tag])}"
                yield Unread(element, what, message, matters=True)
        known = _CHILDREN.get(tag, set())
        for child in element.iterchildren(etree.Element) if known else ():
            name = etree.QName(child)
            if name.namespace is None and child.tag in known:
                waiting.append(child)
                continue
            what = f"<{name.localname}> in <{tag}>"
            is_other = name.namespace is not None or name.localname in _OTHERS.get(tag, ())
            if is_other or (tag == "world" and name.localname not in _WORLD):
                yield Unread(child, what, "", matters=False)
            else:
                message = f"{what} is not known, and left out{hints.of(name.localname, known)}"
                yield Unread(child, what, message, matters=True)
