"""Finds the joints that a group of a semantic description names."""

from dataclasses import replace

from ulna.description.robot_description import Description, Joint
from ulna.description.semantic import Group, Srdf
from ulna.description.structure import joints_to_root


def with_chains_listed(srdf: Srdf, description: Description) -> Srdf:
    """The same groups with the joints of their chains listed one by one, so that the rest of a cut chain is known."""
    carriers = {joint.child: joint for joint in description.joints}
    return replace(srdf, groups=tuple(replace(group, joints=tuple(own_joints(group, carriers))) for group in srdf.groups))


def own_joints(group: Group, carriers: dict[str, Joint]) -> set[str]:
    """The joints listed, those that carry the links listed, and those between the ends of the chains."""
    joints = set(group.joints) | {carriers[link].name for link in group.links if link in carriers}
    return joints.union(*(joints_between(base, tip, carriers) for base, tip in group.chains))


def joints_between(base: str, tip: str, carriers: dict[str, Joint]) -> set[str]:
    """The joints of a chain: those between its two ends."""
    return joints_to_root(base, carriers) ^ joints_to_root(tip, carriers)
