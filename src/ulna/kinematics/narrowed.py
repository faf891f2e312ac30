"""Narrows the limits of a robot to those of a cell or of a controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ulna.description.robot_description import Description, Joint, JointType, frozen
from ulna.errors import InputError
from ulna.kinematics.tree import Narrowed, Tree

_WITH_LIMITS = JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC


def narrowed_tree(tree: Tree, narrowed: Narrowed) -> Tree:
    """The tree with narrower limits; everything else is shared.

    A velocity limit of 0, which exporters write for a missing one, is replaced.
    """
    lower, upper = np.maximum(tree.lower, narrowed.lower), np.minimum(tree.upper, narrowed.upper)
    velocity = np.where(tree.velocity_limits > 0.0, np.minimum(tree.velocity_limits, narrowed.velocity), narrowed.velocity)
    shape = tree.q_shape
    return replace(
        tree,
        lower=frozen(lower, shape),
        upper=frozen(upper, shape),
        soft_lower=frozen(np.clip(tree.soft_lower, lower, upper), shape),
        soft_upper=frozen(np.clip(tree.soft_upper, lower, upper), shape),
        velocity_limits=frozen(np.where(np.isinf(narrowed.velocity), tree.velocity_limits, velocity), shape),
        acceleration_limits=frozen(np.minimum(tree.acceleration_limits, narrowed.acceleration), shape),
        jerk_limits=frozen(np.minimum(tree.jerk_limits, narrowed.jerk), shape),
        narrowed=Narrowed(*(frozen(each, shape) for each in narrowed)),
    )


def narrowed_description(description: Description, tree: Tree) -> Description:
    """The description with the limits of a narrowed tree, without its source text.

    A continuous joint with limits becomes revolute.

    Raises:
        InputError: A planar or a floating joint was narrowed; a description has no such limits for these.
    """
    caps = tree.narrowed
    if caps is None:
        return description
    columns = dict(zip(tree.joint_names, tree.joint_slices, strict=True))

    def narrowed(joint: Joint) -> Joint:
        entries = columns.get(joint.name)
        if entries is None:
            return joint
        lower, upper, velocity = (each[entries] for each in (tree.lower, tree.upper, tree.velocity_limits))
        if joint.type not in _WITH_LIMITS:
            if np.isfinite([lower, upper]).any() or len(set(velocity.tolist())) > 1:
                raise InputError("robot", f"{joint.name!r} was narrowed, and a description has no limits of a {joint.type} joint")
            return replace(joint, limits=replace(joint.limits, velocity=float(velocity[0])))
        acceleration, jerk = (float(each[entries].min()) for each in (caps.acceleration, caps.jerk))
        limits = replace(
            joint.limits,
            lower=float(lower[0]),
            upper=float(upper[0]),
            velocity=float(velocity[0]),
            acceleration=min(joint.limits.acceleration, acceleration),
            deceleration=min(joint.limits.deceleration, acceleration),
            jerk=min(joint.limits.jerk, jerk),
        )
        kind = joint.type
        if kind == JointType.CONTINUOUS and np.isfinite([limits.lower, limits.upper]).any():
            kind = JointType.REVOLUTE
        return replace(joint, type=kind, limits=limits)

    return replace(description, joints=tuple(narrowed(joint) for joint in description.joints), text="")
