"""Checks the goal of a plan: configurations, poses of a link, or a pose for each of several links.

For several links, such as both hands of a robot, each link needs joints that move it and none of the others. Joints that move
several of the links, such as a torso's joints, are held.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.likely_units import degrees_in_words
from ulna.description.pose import as_pose
from ulna.description.semantic import GroupState
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.groups import JointGroup, configuration, state_named, tip_of
from ulna.kinematics.positions import is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]
Targets = Array | dict[str, Array]
"""A checked goal, in one of three forms. Alternative configurations, shape (n, n_dof). Alternative poses by link, shape (n, 4,
4); the links reach the poses of one row together. One pose by link, shape (4, 4); all links reach theirs together."""


def as_targets(
    goal: ArrayLike | Mapping[str, ArrayLike],
    link: str | None,
    tree: Tree,
    start: Array,
    group: JointGroup | None,
    states: tuple[GroupState, ...],
) -> Targets:
    """Check and convert the goal of a plan from a start, shape (n_dof,), for all joints or a group.

    Raises:
        InputError: The goal is invalid; or a link is named in addition to the goal's links; or no joint of the group moves a
            link.
        UnknownNameError: There is no such link or state.
    """
    if isinstance(goal, Mapping):
        if link is not None:
            raise InputError("link", "the goal names its links already")
        targets = _as_links_goal(goal, tree)
    else:
        given = configuration(state_named(goal, states, group), tree, start) if isinstance(goal, str) else goal
        rows = _as_goal(given, tree, start, group)
        if rows.ndim == 2:
            return rows
        targets = {tree.link_or_tip(tip_of(group) if link is None and group is not None else link): rows}
    if group is not None and group.columns:
        for name, columns in own_columns(targets, tree).items():
            if not columns[list(group.columns)].any():
                alone = " and no other link of the goal" if len(targets) > 1 else ""
                argument = "goal" if isinstance(goal, Mapping) else "link"
                raise InputError(argument, f"no joint of the group {group.name!r} moves link {name!r}{alone}")
    return targets


def fixed_entries(targets: Targets, tree: Tree) -> NDArray[np.bool_]:
    """Mask of the entries of q that stay fixed, shape (n_dof,): they move no link of the goal, or several."""
    if isinstance(targets, np.ndarray):
        return np.zeros(tree.n_dof, dtype=bool)
    return ~np.logical_or.reduce(list(own_columns(targets, tree).values()))


def own_columns(links: Mapping[str, object], tree: Tree) -> dict[str, NDArray[np.bool_]]:
    """The mask of each link's own entries of q, which move no other of the links, shape (n_dof,) each."""
    moves = np.zeros((len(links), tree.n_dof), dtype=bool)
    for row, link in zip(moves, links, strict=True):
        row[tree.moving_columns(link)] = True
    return dict(zip(links, moves & (moves.sum(axis=0) == 1), strict=True))


def _as_links_goal(goal: Mapping[str, ArrayLike], tree: Tree) -> dict[str, Array]:
    """Check a goal with a pose for each of several links, shape (4, 4) each.

    Raises:
        InputError: No link is named, a pose is not a rigid motion, or a link has no joints of its own.
        UnknownNameError: There is no such link.
    """
    if not goal:
        raise InputError("goal", "no link is named; a pose for each of some links is expected")
    poses = {}
    for link, T in goal.items():
        if link not in tree.link_names:
            raise UnknownNameError("link", str(link), tree.link_names)
        poses[link] = as_floats("goal", T)
        if poses[link].shape != (4, 4):
            raise InputError("goal", f"shape {poses[link].shape} for link {link!r}; one pose, shape (4, 4), is expected")
        as_pose(poses[link])
    for link, columns in own_columns(poses, tree).items():
        if not columns.any():
            raise InputError("goal", f"no joint moves link {link!r} that does not move another link of the goal")
    return poses


def _is_pose(goal: Array, n_dof: int) -> bool:
    """Whether an array is one pose or several; for four joints the last row of the matrix decides."""
    if goal.ndim == 3:
        return goal.shape[1:] == (4, 4)
    return goal.shape == (4, 4) and (n_dof != 4 or bool((goal[3] == (0.0, 0.0, 0.0, 1.0)).all()))


def _as_goal(goal: ArrayLike, tree: Tree, start: Array, group: JointGroup | None) -> Array:
    """Convert a goal to an array of configurations, shape (n, n_dof), or of poses, shape (n, 4, 4).

    A configuration may have the joints of the group alone; the other entries are the start's. Entries equal to the start's are
    not compared with the limits, since the start itself is checked.

    Raises:
        InputError: The goal is neither; or a configuration lies outside the limits; or a pose is not a rigid motion.
    """
    given = as_floats("goal", goal)
    n_own = tree.n_dof if group is None else len(group.columns)
    if given.size and _is_pose(given, tree.n_dof) and (group is None or _is_pose(given, n_own)):
        poses = given.reshape(-1, 4, 4)
        for T in poses:
            as_pose(T)
        return poses
    if given.ndim not in {1, 2} or given.shape[-1] not in {tree.n_dof, n_own} or not given.size:
        raise InputError("goal", f"shape {given.shape}; {_expected(tree, group)}, are expected")
    if given.shape[-1] == tree.n_dof and is_within(given, tree):
        return given.reshape(-1, tree.n_dof)
    refuse_out_of_range(given, "goal")
    if group is not None and given.shape[-1] != tree.n_dof:
        own, given = given, np.tile(start, (*given.shape[:-1], 1))
        given[..., list(group.columns)] = own
    rows = given.reshape(-1, tree.n_dof)
    beyond = ((rows < tree.lower) | (rows > tree.upper)) & (rows != start)
    if beyond.any():
        row, k = np.argwhere(beyond)[0]
        limits = f"{tree.lower[k]:.6g} to {tree.upper[k]:.6g}"
        hint = degrees_in_words(rows[row])
        raise InputError("goal", f"{rows[row, k]:.6g} of joint {joint_name(k, tree)!r} is outside its limits, {limits}{hint}")
    return rows


def _expected(tree: Tree, group: JointGroup | None) -> str:
    n, poses = tree.n_dof, "poses, shape (4, 4) or (n, 4, 4)"
    if group is None or len(group.columns) == n:
        return f"configurations, shape ({n},) or (n, {n}), or {poses}"
    k = len(group.columns)
    names = ", ".join(group.joint_names[:8]) + (" ..." if len(group.joint_names) > 8 else "")
    alone = f"configurations of the group {group.name!r}, shape ({k},) or (n, {k}): {names}"
    return f"{alone}; or of all joints, shape ({n},) or (n, {n}); or {poses}"


def limit_excess(q: Array, tree: Tree) -> dict[str, float]:
    """The joints beyond their limits at q, shape (n_dof,), and their excess [rad or m]."""
    excess = np.maximum(tree.lower - q, q - tree.upper)
    return {joint_name(k, tree): float(excess[k]) for k in np.flatnonzero(excess > 0).tolist()}


def joint_name(column: int, tree: Tree) -> str:
    """The name of the joint to which an entry of q belongs."""
    slices = zip(tree.joint_names, tree.joint_slices, strict=True)
    return next(name for name, part in slices if part.start <= column < part.stop)
