"""Finds the configurations that a plan may end in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.checker import Checker
from ulna.collision.clouds import PointCloud
from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.arrays import as_floats
from ulna.description.pose import as_pose
from ulna.errors import InputError
from ulna.ik.inverse_kinematics import InverseKinematics
from ulna.ik.options import Options
from ulna.ik.reason import NO_REASON, Reason
from ulna.ik.result import IKResult, Status
from ulna.ik.task import Task
from ulna.kinematics.groups import JointGroup
from ulna.kinematics.positions import is_within, refuse_out_of_range
from ulna.kinematics.sample import random_positions
from ulna.kinematics.tree import Tree
from ulna.planning.plan_status import PlanStatus, in_collision

Array = NDArray[np.float64]
SPREAD = 16  # configurations for a pose of a redundant arm, or places of the joint that its closed form holds
_SEEDS = 16  # from which a pose is searched with joints held


class Goals(NamedTuple):
    """Configurations that a plan may end in.

    Attributes:
        q: The free ones, shape (n, n_dof).
        of: Which of the goals given each belongs to, shape (n,).
        status: If there is none, why.
        reason: The same in words, with the report or the result that shows it.
    """

    q: Array
    of: NDArray[np.int64]
    status: PlanStatus = PlanStatus.SOLVED
    reason: Reason = NO_REASON


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
        clouds = (
            [name for name, shape, _ in self.world.items() if isinstance(shape, PointCloud)] if self.world is not None else []
        )
        return in_collision(Report(counted), self.margin, clouds)


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
        raise InputError("goal", f"{rows[row, k]:.6g} of joint {_joint_of(k, tree)!r} is outside its limits, {limits}")
    return rows


def _expected(tree: Tree, group: JointGroup | None) -> str:
    n, poses = tree.n_dof, "poses, shape (4, 4) or (n, 4, 4)"
    if group is None or len(group.columns) == n:
        return f"configurations, shape ({n},) or (n, {n}), or {poses}"
    k = len(group.columns)
    names = ", ".join(group.joint_names[:8]) + (" ..." if len(group.joint_names) > 8 else "")
    alone = f"configurations of the group {group.name!r}, shape ({k},) or (n, {k}): {names}"
    return f"{alone}; or of all joints, shape ({n},) or (n, {n}); or {poses}"


def _joint_of(column: int, tree: Tree) -> str:
    slices = zip(tree.joint_names, tree.joint_slices, strict=True)
    return next(name for name, part in slices if part.start <= column < part.stop)


def fixed_for(goal: Array, request: Request) -> NDArray[np.bool_]:
    """Which entries of q the goal leaves as they are, shape (n_dof,): for a pose those that do not move the link."""
    columns = np.zeros(request.tree.n_dof, dtype=bool)
    if goal.ndim == 3:
        columns[:] = True
        columns[request.tree.moving_columns(request.tree.link_or_tip(request.link))] = False
    return columns


def find_goals(request: Request, goal: Array, fixed: NDArray[np.bool_], free: NDArray[np.bool_]) -> Goals:
    """The free configurations of a goal; or why there is none.

    fixed: the entries of q that keep their positions, shape (n_dof,); free: which of the configurations given are, shape (n,).

    Raises:
        InputError: A configuration moves a joint that keeps its position.
    """
    if goal.ndim == 3:
        return _of_poses(request, goal, fixed)
    if fixed.any() and (moved := (goal != request.start) & fixed).any():
        row, k = np.argwhere(moved)[0]
        way = f"joint {_joint_of(k, request.tree)!r} is to go from {request.start[k]:.6g} to {goal[row, k]:.6g}"
        raise InputError("goal", f"{way}, but it keeps its position: it is held, or outside the group")
    if free.all():
        return Goals(goal, np.arange(len(goal)))  # the most frequent case
    if free.any():
        return Goals(goal[free], np.flatnonzero(free))
    return Goals(goal[:0], np.empty(0, dtype=np.int64), PlanStatus.GOAL_IN_COLLISION, request.collision(goal[0]))


def _of_poses(request: Request, poses: Array, fixed: NDArray[np.bool_]) -> Goals:
    rows, of = [], []
    for i, T in enumerate(poses):
        found = solutions_of(request, T, fixed)
        found[:, fixed] = request.start[fixed]
        found = found[request.is_free(found)] if len(found) else found
        rows.append(found)
        of.append(np.full(len(found), i))
    q = np.concatenate(rows)
    if len(q):
        return Goals(q, np.concatenate(of))
    return _why_none(request, poses[0], q)


def solutions_of(request: Request, T: Array, fixed: NDArray[np.bool_]) -> Array:
    """All configurations found for a pose that are clear of the world, shape (n, n_dof); ``fixed`` entries may be anything."""
    link = request.tree.link_or_tip(request.link)
    if fixed[request.tree.moving_columns(link)].any():
        n = request.tree.n_dof
        seeds = np.vstack([request.start, random_positions(request.tree, _SEEDS - 1, request.seed)])
        seeds[:, fixed] = request.start[fixed]
        result = solve(request, np.broadcast_to(T, (_SEEDS, 4, 4)).copy(), seeds)
        return np.unique(result.q[result.success].reshape(-1, n), axis=0)
    found = request.inverse_kinematics.all_solutions(
        T, request.start, None, link, Options(seed=request.seed, task=request.task, threads=1), n_samples=SPREAD
    )
    return found.q[found.valid]


def solve(request: Request, T: Array, seeds: Array) -> IKResult:
    """A search for each of several poses, or for one, from seeds in which the joints are held as the request says."""
    search = request.inverse_kinematics.inverse_kinematics
    options = Options(seed=request.seed, task=request.task)
    return search(T, seeds, None, request.held, request.world, request.link, options)


def _why_none(request: Request, T: Array, none: Array) -> Goals:
    """What inverse kinematics says of a pose for which no free configuration was found."""
    result, of_none = solve(request, T, request.start), np.empty(0, dtype=np.int64)
    if result.success and request.is_free(result.q[None])[0]:
        return Goals(result.q[None].copy(), np.zeros(1, dtype=np.int64))
    if result.success or result.status == Status.IN_COLLISION:
        return Goals(none, of_none, PlanStatus.GOAL_IN_COLLISION, request.collision(result.q))
    return Goals(none, of_none, PlanStatus.GOAL_UNREACHABLE, Reason(str(result), result))
