"""Checks the references of an SRDF against its robot, warns of unknown names, and finds the joints of groups."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ulna.description.robot_description import N_POSITIONS, Description, Joint, JointType
from ulna.description.semantic import DisabledCollision, EndEffector, Group, GroupState, Srdf
from ulna.description.structure import joints_to_root
from ulna.errors import DescriptionError, did_you_mean

_N_VALUES = {**N_POSITIONS, JointType.FLOATING: 7}  # in a state a floating joint has a quaternion
_MAX_PAIRS = 1_000_000  # of links that are checked against no other
_MAX_SUGGESTIONS = 20  # searching similar names takes time
_SHORTEST = 1e-12  # minimum length of a valid quaternion
_TOLERANCE = 1e-6  # tolerance of a state that repeats the position of a mimic joint


def matched(srdf: Srdf, description: Description) -> Srdf:
    """A semantic description without references to names that the robot lacks; ``warnings`` lists those."""
    check = _Check(srdf, description)
    return replace(
        srdf,
        groups=tuple(check.group(group) for group in srdf.groups),
        end_effectors=tuple(effector for effector in srdf.end_effectors if check.end_effector(effector)),
        states=tuple(check.state(state) for state in srdf.states),
        disabled_collisions=tuple(check.disabled_collisions()),
        virtual_joints=tuple(
            v for v in srdf.virtual_joints if check.has("link", v.child_link, f"virtual joint {v.name!r}", v.line)
        ),
        passive_joints=tuple(name for name in srdf.passive_joints if check.has("joint", name, "a passive joint", None)),
        unchecked_links=(),
        enabled_collisions=(),
        warnings=(*srdf.warnings, *check.warnings),
    )


class _Check:
    """Looks names up in a robot, and collects the warnings."""

    def __init__(self, srdf: Srdf, description: Description) -> None:
        self.srdf, self.warnings = srdf, []
        self.joints = {joint.name: joint for joint in description.joints}
        self.known = {
            "link": {link.name: None for link in description.links},
            "joint": {**self.joints, **{joint.name: None for joint in srdf.virtual_joints}},
            "group": {group.name: None for group in srdf.groups},
        }

    def has(self, kind: str, name: str, who: str, line: int | None) -> bool:
        """Whether a link, joint or group exists; if not, a warning is added."""
        known = self.known[kind]
        if name not in known:
            suggestion = did_you_mean(name, known, most=3) if len(self.warnings) < _MAX_SUGGESTIONS else ""
            self.warn(f"{who}: {kind} {name!r} is not defined{suggestion}", line)
        return name in known

    def has_all(self, kind: str, names: Iterable[str], who: str, line: int | None) -> bool:
        """Whether all of several names exist; adds a warning for each missing one."""
        return sum(not self.has(kind, name, who, line) for name in names) == 0

    def warn(self, sentence: str, line: int | None) -> None:
        self.warnings.append(str(DescriptionError(sentence, self.srdf.source, line)))

    def group(self, group: Group) -> Group:
        who, line = f"group {group.name!r}", group.line
        return replace(
            group,
            links=tuple(name for name in group.links if self.has("link", name, who, line)),
            joints=tuple(name for name in group.joints if self.has("joint", name, who, line)),
            chains=tuple(ends for ends in group.chains if self.has_all("link", ends, who, line)),
            subgroups=tuple(name for name in group.subgroups if self.has("group", name, who, line)),
        )

    def end_effector(self, effector: EndEffector) -> bool:
        who, groups = f"end effector {effector.name!r}", filter(None, (effector.group, effector.parent_group))
        on_a_link = self.has("link", effector.parent_link, who, effector.line)
        return self.has_all("group", groups, who, effector.line) and on_a_link

    def state(self, state: GroupState) -> GroupState:
        """The state without values of joints that take none: unknown, fixed, mimic and virtual ones."""
        who = f"group state {state.key!r}"
        if state.group is not None:
            self.has("group", state.group, who, state.line)
        values = dict(state.values)
        known = [name for name in values if self.has("joint", name, who, state.line) and name in self.joints]
        kept = tuple((name, values[name]) for name in known if self.value(name, values, who, state.line))
        return replace(state, values=kept)

    def value(self, name: str, values: dict[str, tuple[float, ...]], who: str, line: int | None) -> bool:
        """Whether a joint takes its values; raises an error if their number is wrong, or they are no rotation."""
        joint, given = self.joints[name], values[name]
        if joint.type == JointType.FIXED:
            self.warn(f"{who}: joint {name!r} is fixed and takes no value", line)
            return False
        count = _N_VALUES[joint.type]
        if len(given) != count or (count == 7 and max(abs(x) for x in given[3:]) < _SHORTEST):
            expected = "x, y, z and a quaternion x, y, z, w" if count == 7 else f"{count} number{'s' * (count > 1)}"
            message = f"{who}: joint {name!r} is {joint.type}: {expected} expected, not {_words(given)}"
            raise DescriptionError(message, self.srdf.source, line)
        if joint.mimic is None:
            return True
        leader = values.get(joint.mimic.joint, (float("nan"),))[0]
        if not abs(joint.mimic.multiplier * leader + joint.mimic.offset - given[0]) <= _TOLERANCE:
            self.warn(f"{who}: joint {name!r} follows {joint.mimic.joint!r}; its own value {given[0]:g} is ignored", line)
        return False

    def disabled_collisions(self) -> Iterator[DisabledCollision]:
        """The listed pairs, and the pairs of links that are checked against no other, unless enabled."""
        for pair in self.srdf.disabled_collisions:
            if self.has_all("link", (pair.link_a, pair.link_b), "disabled collision", pair.line):
                yield pair
        links = self.known["link"]
        alone = [name for name in dict.fromkeys(self.srdf.unchecked_links) if self.has("link", name, "disabled collisions", None)]
        if len(alone) * len(links) > _MAX_PAIRS:
            raise DescriptionError(f"disables the collisions of {len(alone)} links with {len(links)}", self.srdf.source)
        enabled = {frozenset(pair) for pair in self.srdf.enabled_collisions}
        for name in alone:
            for other in links:
                if other != name and frozenset((name, other)) not in enabled:
                    yield DisabledCollision(name, other, "Default")


def _words(values: tuple[float, ...], most: int = 8) -> str:
    return " ".join(f"{value:g}" for value in values[:most]) + " ..." * (len(values) > most)


def with_chains_listed(srdf: Srdf, description: Description) -> Srdf:
    """The groups with the joints of their chains listed one by one, which preserves the rest of a cut chain."""
    carriers = {joint.child: joint for joint in description.joints}
    return replace(srdf, groups=tuple(replace(group, joints=tuple(own_joints(group, carriers))) for group in srdf.groups))


def own_joints(group: Group, carriers: dict[str, Joint]) -> set[str]:
    """The listed joints, those that carry the listed links, and those between the ends of the chains."""
    joints = set(group.joints) | {carriers[link].name for link in group.links if link in carriers}
    return joints.union(*(joints_between(base, tip, carriers) for base, tip in group.chains))


def joints_between(base: str, tip: str, carriers: dict[str, Joint]) -> set[str]:
    """The joints of a chain: those between its two ends."""
    return joints_to_root(base, carriers) ^ joints_to_root(tip, carriers)
