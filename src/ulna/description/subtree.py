"""Cuts parts out of a description, and adds a tool to one."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.description.name_checks import refuse_no_name
from ulna.description.references import matched, with_chains_listed
from ulna.description.robot_description import Description, Inertia, Joint, JointType, Link
from ulna.description.structure import joints_below, leaf_links, root_link
from ulna.errors import DescriptionError, InputError, UnknownNameError


def cut_out(description: Description, base: str | None, tip: str | None) -> Description:
    """The robot from ``base`` on (by default the root); with a ``tip`` only the chain between them."""
    root = root_link(description)
    names = [link.name for link in description.links]
    for name in (base, tip):
        if name is not None and name not in names:
            raise UnknownNameError("link", name, names)
    start = base or root
    inside = joints_below(description, start) if tip is None else chain_joints(description, start, tip)
    kept = {joint.name for joint in inside}
    joints = tuple(joint for joint in description.joints if joint.name in kept)
    links = {start} | {joint.child for joint in joints}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in kept:
            message = (
                f"joint {joint.name!r} mimics {joint.mimic.joint!r}, which is not part of the robot from {start!r} to {tip!r}"
            )
            raise DescriptionError(message, description.source, joint.line)
    part = replace(description, links=tuple(link for link in description.links if link.name in links), joints=joints, text="")
    srdf = matched(with_chains_listed(description.srdf, description), part)
    return replace(part, srdf=replace(srdf, warnings=description.srdf.warnings))


def with_tool(
    description: Description, T_flange_tool: NDArray[np.float64], name: str, inertia: Inertia | None = None
) -> Description:
    """The robot with one more link fixed to its only tip."""
    leaves = leaf_links(description)
    if len(leaves) != 1:
        tips = ", ".join(map(repr, leaves[:8])) + (" ..." if len(leaves) > 8 else "")
        best = "tool0" if "tool0" in leaves else next(iter(leaves))
        message = f"the robot has {len(leaves)} tips: {tips}; choose one when it is loaded, as in ulna.load(..., tip={best!r})"
        raise InputError("T_flange_tool", message)
    refuse_no_name(name)
    if name in {link.name for link in description.links}:
        raise InputError("name", f"the robot already has a link {name!r}")
    joint = Joint(f"{name}_joint", JointType.FIXED, leaves[0], name, T_flange_tool, np.array([0.0, 0.0, 1.0]))
    link = Link(name, inertia=inertia)
    return replace(description, links=(*description.links, link), joints=(*description.joints, joint), text="")


def chain_joints(description: Description, base: str, tip: str) -> tuple[Joint, ...]:
    """The joints from base to tip."""
    carriers = {joint.child: joint for joint in description.joints}
    link, joints = tip, []
    while link != base:
        joint = carriers.get(link)
        if joint is None:
            advice = f"load from {link!r} on, and frame={base!r} states poses in {base!r}"
            message = f"link {tip!r} is not below {base!r}: the chain from it ends at {link!r}. {advice}"
            raise DescriptionError(message, description.source)
        joints.append(joint)
        link = joint.parent
    return tuple(reversed(joints))
