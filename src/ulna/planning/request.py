"""Holds what a plan is requested to do, and checks its goal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError, UnknownNameError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.reason import Reason
from ulna.ik.task import Task
from ulna.kinematics.groups import JointGroup
from ulna.kinematics.positions import is_within, refuse_out_of_range
from ulna.kinematics.tree import Tree
from ulna.planning.plan_status import in_collision

Array = NDArray[np.float64]


class Request(NamedTuple):
    """What a plan is asked for, checked.

    Attributes:
        checker: Tests configurations.
        inverse_kinematics: Finds those of a pose.
        world: The objects, if any.
        margin: How near an object may be [m].
        start: The configuration to start from, shape (n_dof,).
        held: The joints that keep their positions.
        link: The link that is brought to a pose.
        task: The components of the pose that count.
        seed: Chooses the starts of the search for a pose.
    """

    checker: Checker
    inverse_kinematics: InverseKinematics
    world: World | None
    margin: float
    start: Array
    held: tuple[str, ...]
    link: str | None
    task: Task | str
    seed: int

    @property
    def tree(self) -> Tree:
        """The robot."""
        return self.checker.tree

    def is_free(self, q: Array) -> NDArray[np.bool_]:
        """Which configurations, shape (n, n_dof), touch nothing, and keep the margin from the world."""
        free = np.logical_not(self.checker.in_collision(q, self.world, self_collision=True))
        if self.margin > 0.0 and self.world is not None and self.world.names:
            free &= self.checker.signed_distance(q, self.world, self_collision=False) > self.margin
        return free

    def collision(self, q: Array) -> Reason:
        """The pairs that touch at q, or of which an object of the world is nearer than the margin."""
        near = self.checker.check_collision(q, self.world, self_collision=True, max_distance=self.margin)
        counted = tuple(pair for pair in near.pairs if pair.link_b is None or pair.signed_distance <= 0.0)
        return in_collision(Report(counted), self.margin)


def is_pose(goal: Array, n_dof: int) -> bool:
    """Whether a goal, as an array, is a pose or several: for an arm of four joints, by the last row of the matrix."""
    if goal.ndim == 3:
        return goal.shape[1:] == (4, 4)
    return goal.shape == (4, 4) and (n_dof != 4 or bool((goal[3] == (0.0, 0.0, 0.0, 1.0)).all()))


def as_goal(goal: ArrayLike, tree: Tree, start: Array, group: JointGroup | None = None) -> Array:
    """A goal as an array of configurations, shape (n, n_dof), or of poses, shape (n, 4, 4).

    A configuration may have the joints of the group alone; then the others are as in ``start``. An entry that is as in ``start``
    is not compared with the limits: where it is beyond them, the start is.

    Raises:
        InputError: It is neither; or a configuration lies outside the limits; or a pose is not a rigid motion.
    """
    given = as_floats("goal", goal)
    n_own = tree.n_dof if group is None else len(group.columns)
    if given.size and is_pose(given, tree.n_dof) and is_pose(given, n_own):
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
        raise InputError("goal", f"{rows[row, k]:.6g} of joint {joint_of(k, tree)!r} is outside its limits, {limits}")
    return rows


def _expected(tree: Tree, group: JointGroup | None) -> str:
    n, poses = tree.n_dof, "poses, shape (4, 4) or (n, 4, 4)"
    if group is None or len(group.columns) == n:
        return f"configurations, shape ({n},) or (n, {n}), or {poses}"
    k = len(group.columns)
    names = ", ".join(group.joint_names[:8]) + (" ..." if len(group.joint_names) > 8 else "")
    alone = f"configurations of the group {group.name!r}, shape ({k},) or (n, {k}): {names}"
    return f"{alone}; or of all joints, shape ({n},) or (n, {n}); or {poses}"


def joint_of(column: int, tree: Tree) -> str:
    """The joint that an entry of q belongs to."""
    slices = zip(tree.joint_names, tree.joint_slices, strict=True)
    return next(name for name, part in slices if part.start <= column < part.stop)


def as_links_goal(goal: Mapping[str, ArrayLike], tree: Tree) -> dict[str, Array]:
    """A pose for each of several links, shape (4, 4) each.

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


def own_columns(links: Mapping[str, object], tree: Tree) -> dict[str, NDArray[np.bool_]]:
    """By link: the entries of q that move it and none of the others, shape (n_dof,) each."""
    moves = np.zeros((len(links), tree.n_dof), dtype=bool)
    for row, link in zip(moves, links, strict=True):
        row[tree.moving_columns(link)] = True
    return dict(zip(links, moves & (moves.sum(axis=0) == 1), strict=True))


def fixed_for(goal: Array, request: Request) -> NDArray[np.bool_]:
    """Which entries of q the goal leaves as they are, shape (n_dof,): for a pose those that do not move the link."""
    columns = np.zeros(request.tree.n_dof, dtype=bool)
    if goal.ndim == 3:
        columns[:] = True
        columns[request.tree.moving_columns(request.tree.link_or_tip(request.link))] = False
    return columns


def fixed_for_links(poses: Mapping[str, Array], tree: Tree) -> NDArray[np.bool_]:
    """The entries of q that move none of the links, or several, shape (n_dof,)."""
    return ~np.logical_or.reduce(list(own_columns(poses, tree).values()))
