"""Checks that links and joints form one tree, and orders them from the root.

It also assigns to each joint the entries of q that move it.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ulna.description.name_checks import name_fault
from ulna.description.robot_description import N_POSITIONS, Description, Joint, JointType, Mimic
from ulna.errors import DescriptionError, did_you_mean
from ulna.kernels.layout import LARGEST

_BOUNDED = (JointType.REVOLUTE, JointType.PRISMATIC)
_MAX_MEANT = 1e300  # a larger limit means none: Gazebo writes 1.79769e308, with which differences overflow


@dataclass(frozen=True)
class Drive:
    """A joint's relation to q: position = ratio * q[column] + offset; ``column`` is None for a fixed joint."""

    column: int | None
    ratio: float = 1.0
    offset: float = 0.0


def root_link(description: Description) -> str:
    """The root: the only link that is not the child of a joint."""
    links = _by_unique_name(description, "link", description.links)
    _by_unique_name(description, "joint", description.joints)
    if not links:
        raise DescriptionError("the robot has no links", description.source)
    parent_joint: dict[str, Joint] = {}
    for joint in description.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                message = f"joint {joint.name!r}: {role} link {name!r} is not defined{did_you_mean(name, links)}"
                raise DescriptionError(message, description.source, joint.line)
        if joint.child in parent_joint:
            other = parent_joint[joint.child].name
            message = f"link {joint.child!r} is the child of two joints, {other!r} and {joint.name!r}"
            raise DescriptionError(f"{message}: closed loops are not supported", description.source, joint.line)
        parent_joint[joint.child] = joint
    roots = [name for name in links if name not in parent_joint]
    if not roots:
        raise DescriptionError("every link is the child of some joint: the joints form a loop", description.source)
    if len(roots) > 1:
        raise DescriptionError(
            f"{len(roots)} links have no parent ({', '.join(roots[:8])}): one root is expected", description.source
        )
    return roots[0]


def joints_from_root(description: Description) -> tuple[Joint, ...]:
    """The joints, each after the joint of its parent link; otherwise in the order of the file, depth first."""
    ordered = joints_below(description, root_link(description))
    if len(ordered) < len(description.joints):
        reached = {joint.name for joint in ordered}
        lost = next(joint for joint in description.joints if joint.name not in reached)
        message = f"joint {lost.name!r} is part of a loop of joints that the root does not reach"
        raise DescriptionError(message, description.source, lost.line)
    return ordered


def joints_below(description: Description, link: str) -> tuple[Joint, ...]:
    """The joints below a link, each after its parent link's joint; otherwise in file order, depth first."""
    children: dict[str, list[Joint]] = defaultdict(list)
    for joint in description.joints:
        children[joint.parent].append(joint)
    ordered, waiting = [], children[link][::-1]
    while waiting:
        joint = waiting.pop()
        ordered.append(joint)
        waiting.extend(reversed(children[joint.child]))
    return tuple(ordered)


def joints_to_root(link: str, carriers: dict[str, Joint]) -> set[str]:
    """The names of the joints between a link and the root. ``carriers`` has the joint that carries each link."""
    names = set()
    while link in carriers:
        names.add(carriers[link].name)
        link = carriers[link].parent
    return names


def leaf_links(description: Description) -> tuple[str, ...]:
    """The moved links without children, in the order of the file; all childless links if none moves.

    The arms of ROS-Industrial have a link ``base`` next to ``base_link``, for the frame of their controller: it is no tip of an
    arm.
    """
    ordered, parents = joints_from_root(description), {joint.parent for joint in description.joints}
    moved = {joint.child for joint in moving_joints(description, ordered)}
    for joint in ordered:
        if joint.parent in moved:
            moved.add(joint.child)
    leaves = [link.name for link in description.links if link.name not in parents]
    return tuple(name for name in leaves if name in moved or moved.isdisjoint(leaves))


def columns_of_q(joints: tuple[Joint, ...]) -> dict[str, slice]:
    """The entries of q of each independent joint, by name in the given order."""
    columns, start = {}, 0
    for joint in joints:
        width = N_POSITIONS[joint.type]
        if width and joint.mimic is None:
            columns[joint.name] = slice(start, start + width)
            start += width
    return columns


def drives_of(joints: tuple[Joint, ...], columns: dict[str, slice], source: str) -> dict[str, Drive]:
    """The drive of each joint; mimics are followed to the independent or fixed joint at their end."""
    by_name, drives = {joint.name: joint for joint in joints}, {}
    for start in joints:
        followers: dict[str, Joint] = {}
        joint = start
        while joint.name not in drives and joint.mimic is not None:
            followers[joint.name] = joint
            joint = _leader(joint, by_name, followers, source)
        if joint.name not in drives:
            fixed = joint.type == JointType.FIXED
            drives[joint.name] = Drive(None, 0.0) if fixed else Drive(columns[joint.name].start)
        for follower in reversed(followers.values()):
            drive, mimic = drives[joint.name], follower.mimic or Mimic("")
            ratio, offset = mimic.multiplier * drive.ratio, mimic.multiplier * drive.offset + mimic.offset
            if not (abs(ratio) <= LARGEST and abs(offset) <= LARGEST):
                message = f"joint {follower.name!r} follows at a ratio of {ratio:g}, off by {offset:g}: beyond {LARGEST:g}"
                raise DescriptionError(f"{message} angles lose their digits", source, follower.line)
            drives[follower.name], joint = Drive(drive.column, ratio, offset), follower
    return drives


def _leader(joint: Joint, joints: dict[str, Joint], followers: dict[str, Joint], source: str) -> Joint:
    """The joint that a joint mimics; raises an error if it cannot be followed."""
    followed = "" if joint.mimic is None else joint.mimic.joint
    leader = joints.get(followed)
    if N_POSITIONS[joint.type] > 1:
        raise DescriptionError(f"joint {joint.name!r}: a {joint.type} joint cannot mimic another", source, joint.line)
    if leader is None:
        message = f"joint {joint.name!r} mimics {followed!r}, which is not defined{did_you_mean(followed, joints)}"
        raise DescriptionError(message, source, joint.line)
    if leader.name in followers:
        names = [*followers, leader.name]
        names = [*names[:4], "...", *names[-4:]] if len(names) > 10 else names
        raise DescriptionError(f"joints {' -> '.join(names)} mimic each other in a circle", source, joint.line)
    if N_POSITIONS[leader.type] > 1:
        message = f"joint {joint.name!r} mimics {leader.name!r}, a {leader.type} joint: no single number to follow"
        raise DescriptionError(message, source, joint.line)
    return leader


def moving_joints(description: Description, joints: Iterable[Joint]) -> tuple[Joint, ...]:
    """The given joints that an entry of q moves, directly or as a mimic."""
    ordered = joints_from_root(description)
    drives = drives_of(ordered, columns_of_q(ordered), description.source)
    return tuple(joint for joint in joints if joint.type != JointType.FIXED and drives[joint.name].column is not None)


def velocity_limits_of_q(joints: tuple[Joint, ...]) -> np.ndarray:
    """The velocity limit of each entry of q; infinite if not given."""
    return np.array([joint.limits.velocity for joint in joints if joint.mimic is None for _ in range(N_POSITIONS[joint.type])])


def effort_limits_of_q(joints: tuple[Joint, ...]) -> np.ndarray:
    """The torque or force limit of each entry of q; infinite if not given."""
    return np.array([joint.limits.effort for joint in joints if joint.mimic is None for _ in range(N_POSITIONS[joint.type])])


def acceleration_limits_of_q(joints: tuple[Joint, ...], drives: dict[str, Drive]) -> np.ndarray:
    """The limits of acceleration and jerk of each entry of q, shape (2, n_dof); infinite if not given.

    The deceleration limit bounds the acceleration too. A mimic joint limits its leader by its own limits divided by their ratio.
    """
    n_dof = sum(N_POSITIONS[joint.type] for joint in joints if joint.mimic is None)
    most = np.full((2, n_dof), np.inf)
    for joint in joints:
        drive = drives[joint.name]
        if drive.column is not None and drive.ratio != 0:
            own = min(joint.limits.acceleration, joint.limits.deceleration), joint.limits.jerk
            columns = slice(drive.column, drive.column + N_POSITIONS[joint.type])
            most[:, columns] = np.minimum(most[:, columns], np.array(own)[:, None] / abs(drive.ratio))
    return most


def bounds_of_q(
    joints: tuple[Joint, ...], drives: dict[str, Drive], bounds_of: Callable[[Joint], tuple[float, float]]
) -> tuple[np.ndarray, set[str]]:
    """Lower and upper bounds of q, shape (2, n_dof), and the names of the joints whose bounds are ignored.

    The bounds are infinite for continuous, planar and floating joints. ``bounds_of`` returns the bounds of a joint:
    ``hard_bounds`` or ``soft_bounds``. The bounds of a mimic joint narrow those of its leader, unless they leave no range at all.
    Such a description contradicts itself (the gripper of ``pr2.urdf`` does), but its authors meant it to move.
    """
    bounds: list[tuple[float, float]] = []
    ignored: set[str] = set()
    for joint in joints:
        width = N_POSITIONS[joint.type] if joint.mimic is None else 0
        bounds += [bounds_of(joint) if joint.type in _BOUNDED else (-np.inf, np.inf)] * width
    for joint in joints:
        drive = drives[joint.name]
        if joint.mimic is not None and joint.type in _BOUNDED and drive.column is not None and drive.ratio != 0:
            low, high = sorted((bound - drive.offset) / drive.ratio for bound in bounds_of(joint))  # bounds of its leader
            narrowed = max(low, bounds[drive.column][0]), min(high, bounds[drive.column][1])
            if narrowed[0] < narrowed[1]:
                bounds[drive.column] = narrowed
            else:
                ignored.add(joint.name)
    return np.array(bounds).reshape(-1, 2).T, ignored


def hard_bounds(joint: Joint) -> tuple[float, float]:
    """The limits of a joint; infinite if the file writes the largest number for none."""
    lower, upper = joint.limits.lower, joint.limits.upper
    return -np.inf if lower < -_MAX_MEANT else lower, np.inf if upper > _MAX_MEANT else upper


def soft_bounds(joint: Joint) -> tuple[float, float]:
    """The soft limits of a joint's safety controller, within its hard limits; without one the hard limits.

    Soft limits that lie wholly outside the limits would leave no range: they are ignored too.
    """
    lower, upper = hard_bounds(joint)
    if joint.safety is None or joint.safety.soft_lower > upper or joint.safety.soft_upper < lower:
        return lower, upper
    return max(lower, joint.safety.soft_lower), min(upper, joint.safety.soft_upper)


def _by_unique_name(description: Description, kind: str, items) -> dict:
    found: dict = {}
    for item in items:
        if fault := name_fault(item.name):
            raise DescriptionError(f"the name of a {kind}: {fault}", description.source, item.line)
        if item.name in found:
            raise DescriptionError(f"{kind} {item.name!r} is defined twice", description.source, item.line)
        found[item.name] = item
    return found
