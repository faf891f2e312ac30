"""Resolves the frames in which a user states poses and twists: a fixed link, or a pose in the base."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_one_pose, as_pose
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.tree import BASE, Tree

Array = NDArray[np.float64]
Goal = ArrayLike | Mapping[str, ArrayLike]
Frame = str | ArrayLike
"""A link by name, such as ``base`` of a UR, the frame of its pendant; or T_base_frame, shape (4, 4), as of a work object."""


def standing_links(tree: Tree) -> tuple[str, ...]:
    """The links that no joint moves, including the base."""
    return tuple(name for name in tree.link_names if tree.link_row[name] == BASE)


def frame_pose(tree: Tree, frame: Frame) -> Array:
    """The pose of a frame in the robot's base, T_base_frame, shape (4, 4).

    Raises:
        InputError: It is a link that a joint moves, or not a pose.
        UnknownNameError: There is no such link.
    """
    if not isinstance(frame, str):
        return as_one_pose(frame, "frame")
    if frame not in tree.link_row:
        raise UnknownNameError("link", frame, tree.link_names)
    if tree.link_row[frame] != BASE:
        advice = "robot.forward_kinematics(q, link=...) gives its pose at a q, which frame= takes too"
        message = f"link {frame!r} moves in the base {tree.root!r}, but the frame of targets must be fixed: {advice}"
        raise InputError("frame", message)
    return tree.link_offset[frame].copy()


def poses_in_base(tree: Tree, T: ArrayLike, frame: Frame | None, name: str = "T") -> ArrayLike:
    """Transform poses from a frame to the base, shape (..., 4, 4); unchanged without a frame."""
    return T if frame is None else frame_pose(tree, frame) @ as_pose(T, name)


def goal_in_base(tree: Tree, goal: Goal, frame: Frame | None) -> Goal:
    """Transform the poses of a goal to the base; a configuration has no frame."""
    if frame is None:
        return goal
    if isinstance(goal, Mapping):
        return {link: poses_in_base(tree, T, frame, "goal") for link, T in goal.items()}
    if isinstance(goal, str) or np.shape(goal)[-2:] != (4, 4):
        raise InputError("frame", "needs a goal of poses; joint positions and states have no frame")
    return poses_in_base(tree, goal, frame, "goal")


def twist_in_base(tree: Tree, twist: ArrayLike, frame: Frame | None) -> ArrayLike:
    """Rotate twists from the axes of a frame to those of the base, shape (..., 6); unchanged without a frame."""
    if frame is None:
        return twist
    values = as_floats("twist", twist)
    if values.shape[-1:] != (6,):
        return values  # its user raises the error
    R = frame_pose(tree, frame)[:3, :3]
    return np.concatenate([values[..., :3] @ R.T, values[..., 3:] @ R.T], axis=-1)
