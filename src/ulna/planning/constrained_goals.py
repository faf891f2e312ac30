"""Finds goal configurations that satisfy a motion's constraints.

If a goal leaves a link's rotation free and a constraint of the same link does not, the shortest rotation onto the constraint is
chosen. The redundancy of the arm is sampled: more configurations of the same poses are tried.

A constraint may tie another link to the goal's link, as two hands that hold one object. Then that link gets a goal pose too.
Inverse kinematics is solved for each link separately, and combined as in ``goals``.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.task import Task, as_task
from ulna.kernels.layout import BASE
from ulna.kinematics.tree import Tree
from ulna.planning.constraint_table import satisfy_constraints, violations
from ulna.planning.goals import N_SAMPLES_PER_POSE, Goals, Request, free_goals, reached_poses
from ulna.planning.keep import Keep
from ulna.planning.plan import Plan, PlanStatus, no_plan
from ulna.planning.targets import Targets, own_columns

Array = NDArray[np.float64]
_MORE = 16  # factor of the number of configurations per pose in the second round
_MAX_POSES = 16  # sampled poses of a goal with free components, for each of which another link gets a pose
_FREE = float("inf")
_OPPOSITE = 1e-12  # for a smaller 1 + cos, two directions count as opposite


def relative_goal_poses(targets: Targets, keeps: tuple[Keep, ...], tree: Tree) -> dict[str, Array]:
    """The pose T_goal_link, shape (4, 4), of each link that constraints tie to the goal's link, by link.

    The result is empty unless each of these links, and the goal's link, has joints that move only it. The goal's link may also
    be fixed to a link that a constraint names.
    """
    if not isinstance(targets, dict) or len(targets) > 1 or all(keep.relative_to is None for keep in keeps):
        return {}
    link = next(iter(targets))
    seen, found = {tree.link_row[link]: inverse(tree.link_offset[link])}, {}  # poses of joints relative to the goal's link
    for keep in keeps * len(keeps):  # repeated: a third hand may be tied to the second
        if keep.relative_to is None or keep.towards:
            continue
        for a, b, T_a_b in (
            (keep.relative_to, str(keep.link), keep.pose),
            (str(keep.link), keep.relative_to, inverse(keep.pose)),
        ):
            if tree.link_row[a] in seen and tree.link_row[b] not in {*seen, BASE}:
                found[b] = seen[tree.link_row[a]] @ tree.link_offset[a] @ T_a_b
                seen[tree.link_row[b]] = found[b] @ inverse(tree.link_offset[b])
    return found if all(columns.any() for columns in own_columns({link: None, **found}, tree).values()) else {}


def find_goals(request: Request, targets: Targets, free: NDArray[np.bool_]) -> Goals | Plan:
    """Find the free goals that satisfy the constraints of a request, or return a failed plan with the reason.

    free: mask of the given configurations that are free, shape (n,).
    """
    first = _goals_of_all_links(request, targets, free)
    if isinstance(first, Plan) or request.search_constraints is None:
        return first
    goals = _filter_goals(first, request)
    if goals is None and isinstance(targets, dict):
        goals = next(_more_goals(request, targets, free), None)
    if goals is None:
        return no_plan(request.tree, PlanStatus.GOAL_OUTSIDE, violations(request.keeps, request.tree, first.q[0]))
    return goals


def _goals_of_all_links(request: Request, targets: Targets, free: NDArray[np.bool_]) -> Goals | Plan:
    """The free goals, with a pose for each tied link; free components of the task are sampled."""
    relative_poses = request.relative_poses
    if not relative_poses or not isinstance(targets, dict):
        return free_goals(request, targets, free)
    link, poses = next((link, T.reshape(-1, 4, 4)) for link, T in targets.items())
    goal_index = np.arange(len(poses))
    if any(as_task(request.task).slack):
        reached = [reached_poses(request, {**relative_poses, link: T}, link, _MAX_POSES) for T in poses]
        if any(map(len, reached)):  # otherwise inverse kinematics of the task gives the reason
            goal_index, poses = np.repeat(goal_index, [len(T) for T in reached]), np.concatenate(reached)
            request = request._replace(task="pose")
    goals = free_goals(request, {link: poses, **{name: poses @ T for name, T in relative_poses.items()}}, free)
    return goals._replace(goal_index=goal_index[goals.goal_index]) if isinstance(goals, Goals) else goals


def _more_goals(request: Request, targets: dict[str, Array], free: NDArray[np.bool_]) -> Iterator[Goals]:
    """Yield goals that satisfy the constraints: first with rotations aligned to them, then from more configurations."""
    link, T = next(iter(targets.items()))
    ways = [(targets, request)]
    if T.ndim == 3:
        for keep in (each for each in request.keeps if each.link == link and each.relative_to is None and not each.towards):
            found = [align_to_constraint(keep, pose, as_task(request.task)) for pose in T]
            if all(each is not None for each in found):
                poses, tasks = zip(*found, strict=True)
                ways.insert(0, ({link: np.array(poses)}, request._replace(task=tasks[0])))
    for each, asked in ways:
        more = _goals_of_all_links(asked._replace(spread=_MORE * N_SAMPLES_PER_POSE), each, free)
        goals = None if isinstance(more, Plan) else _filter_goals(more, request)
        if goals is not None:
            yield goals


def _filter_goals(goals: Goals, request: Request) -> Goals | None:
    """The goals that satisfy the constraints; None if there are none."""
    kept = satisfy_constraints(request.search_constraints, request.tree, goals.q, goals.q)
    return Goals(goals.q[kept], goals.goal_index[kept]) if kept.any() else None


def align_to_constraint(keep: Keep, T: Array, task: Task) -> tuple[Array, Task] | None:
    """A pose that satisfies a task at T, shape (4, 4), and a constraint's orientation; and its task.

    None if the task leaves no rotation free, or the constraint does not restrict the rotation.
    """
    turns_free = np.isinf(task.slack[3:]).tolist()
    if keep.task.slack[3] == _FREE or not any(turns_free):
        return None
    R, kept, position = T[:3, :3], keep.pose[:3, :3], task.slack[:3]
    axis = np.array(keep.task.axis)
    if all(turns_free):
        if keep.keeps_axis:
            return _with_rotation(T, shortest_rotation(R @ axis, kept @ axis) @ R), Task(
                (*position, 0.0, 0.0, _FREE), keep.task.axis
            )
        return _with_rotation(T, kept), Task((*position, 0.0, 0.0, 0.0))
    if keep.keeps_axis:
        return None
    axis = np.array(task.axis)
    return _with_rotation(T, shortest_rotation(kept @ axis, R @ axis) @ kept), Task((*position, 0.0, 0.0, 0.0))


def shortest_rotation(a: Array, b: Array) -> Array:
    """The rotation matrix of the smallest angle that turns one unit vector to another; Rodrigues' formula without the angle."""
    v, c = np.cross(a, b).astype(np.float64), float(a @ b)
    if 1.0 + c < _OPPOSITE:
        n = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return 2.0 * np.outer(n, n).astype(np.float64) / float(n @ n) - np.eye(3)
    K = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + K + K @ K / (1.0 + c)


def _with_rotation(T: Array, R: Array) -> Array:
    posed = T.copy()
    posed[:3, :3] = R
    return posed
