"""Pairs the joints and links of two robots."""

from collections.abc import Iterator
from dataclasses import dataclass

from ulna.description.robot_description import Description, Joint, JointType
from ulna.description.structure import joints_from_root
from ulna.robot import Robot


@dataclass(frozen=True)
class Matching:
    """Pairs of joints and of link names, ``by`` "name" or "order", and the links in which poses are compared."""

    by: str
    joints: tuple[tuple[Joint, Joint], ...]
    links: tuple[tuple[str, str], ...]
    frames: tuple[str, str]


def match(a: Robot, b: Robot) -> Matching:
    """By name, unless fewer than half of the moving joints of the smaller robot share theirs; then by order from the root.

    A link whose name the other robot lacks corresponds to the child of the same joint there, the root to the root, the tip to
    the tip.
    """
    moving_a, moving_b = _moving(a.description), _moving(b.description)
    others = {joint.name: joint for joint in b.description.joints}
    shared = sum(joint.name in others for joint in moving_a)
    by_name = 2 * shared >= min(len(moving_a), len(moving_b))
    if by_name:
        joints = [(joint, others[joint.name]) for joint in a.description.joints if joint.name in others]
    else:
        joints = list(zip(moving_a, moving_b, strict=False))
    named = [(name, name) for name in a.link_names if name in b.link_names]
    carried = [(one.child, other.child) for one, other in joints]
    ends = [(a.base, b.base), *([(a.tip, b.tip)] if a.tip is not None and b.tip is not None else [])]
    links = dict(_first_of_each([*named, *carried, *ends] if by_name else [*carried, *named, *ends]))
    ordered = tuple((name, links[name]) for name in a.link_names if name in links)
    frames = next((pair for pair in ordered if pair[0] == a.base or pair[1] == b.base), (a.base, b.base))
    return Matching("name" if by_name else "order", tuple(joints), ordered, frames)


def _first_of_each(pairs: list[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """The pairs, without those of which one is in an earlier pair."""
    taken_a, taken_b = set(), set()
    for one, other in pairs:
        if one not in taken_a and other not in taken_b:
            taken_a.add(one)
            taken_b.add(other)
            yield one, other


def _moving(description: Description) -> list[Joint]:
    return [joint for joint in joints_from_root(description) if joint.type != JointType.FIXED and joint.mimic is None]
