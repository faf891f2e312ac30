"""Resolves the groups and states of a semantic description on a robot: joints, links, entries of q."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import matrix_from_quaternion, rpy_from_matrix
from ulna.description.references import joints_between, own_joints
from ulna.description.robot_description import Description, Joint, frozen
from ulna.description.semantic import Group, GroupState
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.tree import Tree


@dataclass(frozen=True)
class JointGroup:
    """A group of joints: its independent joints, their entries of q, and the links that it moves.

    Joints and entries are in the order of q. ``link_names`` are, in the order of the robot, the listed links and the
    child links of all joints, fixed and mimic joints too. As in MoveIt, a chain has the joints between its two ends, so its base
    link is not among the links.

    ``tips`` are the last links of its chains, without those that another chain continues. In a group without chains they are the
    links without a child in the group. If there are several, and exactly one end effector has the group as its ``parent_group``,
    the tip is that end effector's parent link.
    """

    name: str
    joint_names: tuple[str, ...]
    columns: tuple[int, ...]
    link_names: tuple[str, ...]
    tips: tuple[str, ...]

    @property
    def tip(self) -> str | None:
        """The only one of ``tips``; None if there are several, or none."""
        return self.tips[0] if len(self.tips) == 1 else None


def joint_groups(description: Description, tree: Tree) -> dict[str, JointGroup]:
    """All groups of a robot, by name."""
    groups = {group.name: group for group in description.srdf.groups}
    carriers = {joint.child: joint for joint in description.joints}
    own_joints_by_group = {name: own_joints(group, carriers) for name, group in groups.items()}
    children = {joint.name: joint.child for joint in description.joints}
    effector_links = {}
    for effector in description.srdf.end_effectors:
        effector_links.setdefault(effector.parent_group, set()).add(effector.parent_link)
    slices = dict(zip(tree.joint_names, tree.joint_slices, strict=True))
    resolved = {}
    for name in groups:
        members = _subgroup_names(name, groups)
        joints = set().union(*(own_joints_by_group[member] for member in members))
        links = {children[joint] for joint in joints if joint in children}.union(*(groups[m].links for m in members))
        moving = tuple(joint for joint in slices if joint in joints)
        columns = tuple(column for joint in moving for column in range(slices[joint].start, slices[joint].stop))
        tips = _ends({chain for member in members for chain in groups[member].chains}, carriers)
        tips = tips or links - {carriers[link].parent for link in links if link in carriers}
        tips = effector_links[name] if len(tips) > 1 and len(effector_links.get(name, ())) == 1 else tips
        of_links, of_tips = (tuple(link for link in tree.link_names if link in some) for some in (links, tips))
        resolved[name] = JointGroup(name, moving, columns, of_links, of_tips)
    return resolved


def group_named(name: str, groups: Mapping[str, JointGroup]) -> JointGroup:
    """The group of this name."""
    if not isinstance(name, str):
        raise InputError("group", f"{type(name).__name__}; the name of a group of the SRDF is expected")
    if name not in groups:
        hint = "" if groups else "; groups are read from an SRDF: ulna.load(..., srdf=...)"
        raise UnknownNameError("group", name, groups, hint)
    return groups[name]


def state_named(name: str, states: Iterable[GroupState], group: JointGroup | None) -> GroupState:
    """The state with this key, or the group's state of this name.

    Without a group, a name that only one state has is enough.
    """
    by_key = {state.key: state for state in states}
    same_name = [key for key, state in by_key.items() if state.name == name]
    key = name if name in by_key or group is None else f"{group.name}/{name}"
    if key not in by_key and group is None and len(same_name) == 1:
        key = same_name[0]
    if key not in by_key:
        hint = "" if by_key else "; states are read from an SRDF: ulna.load(..., srdf=...)"
        raise UnknownNameError("state of the SRDF", name, same_name or by_key, hint)
    return by_key[key]


def tip_of(group: JointGroup) -> str:
    """The link of a pose for which only the group is named."""
    if group.tip is None:
        ends = f"the tips {', '.join(group.tips)}" if group.tips else "no links"
        raise InputError("link", f"the group {group.name!r} has {ends}; name the link that the pose is of")
    return group.tip


def configuration(state: GroupState, tree: Tree, home: NDArray[np.float64]) -> NDArray[np.float64]:
    """The q of a state, read-only; joints that it does not name are as in ``home``."""
    q, slices = np.array(home), dict(zip(tree.joint_names, tree.joint_slices, strict=True))
    for name, values in state.values:
        q[slices[name]] = values if len(values) < 7 else [*values[:3], *_rpy(*values[3:])]
    return frozen(q, q.shape)


def _rpy(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    return rpy_from_matrix(matrix_from_quaternion((w, x, y, z)))


def _ends(chains: set[tuple[str, str]], carriers: dict[str, Joint]) -> set[str]:
    """The last links of some chains, without those that lie before the end of another chain."""
    joints = set().union(*(joints_between(base, tip, carriers) for base, tip in chains))
    return {tip for _, tip in chains} - {joint.parent for joint in carriers.values() if joint.name in joints}


def _subgroup_names(name: str, groups: dict[str, Group]) -> set[str]:
    found, waiting = {name}, [name]
    while waiting:
        new = set(groups[waiting.pop()].subgroups) - found
        found |= new
        waiting += new
    return found
