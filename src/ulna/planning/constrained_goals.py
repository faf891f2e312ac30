"""Finds goals that keep a motion's constraints: those of a pose whose free turns are used to keep them, and more of them.

What a goal leaves free of a link's orientation, and a constraint of the same link does not, is chosen by the shortest turn. What
the joints leave free, as those of a redundant arm do, is searched: more configurations of the same poses are tried.

A link that is kept at a pose seen from the goal's link, as one hand of two that hold one object, has a pose at the goal too: the
inverse kinematics of each is a problem of its own, and what is free together is a goal (``goals``).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.task import Task, as_task
from ulna.kernels.layout import BASE
from ulna.kinematics.tree import Tree
from ulna.planning.constraint_table import are_kept, violations
from ulna.planning.goals import SPREAD, Goals, Request, free_goals, poses_reached
from ulna.planning.keep import Keep
from ulna.planning.plan import Plan, PlanStatus, no_plan
from ulna.planning.targets import Targets, own_columns

Array = NDArray[np.float64]
_MORE = 16  # times as many configurations of a pose
_MAX_POSES = 16  # of a goal that leaves something free, with each of which another link has a pose
_FREE = float("inf")
_OPPOSITE = 1e-12  # of 1 + cos: directions between which the shortest turn may be about any axis


def poses_beside(targets: Targets, keeps: tuple[Keep, ...], tree: Tree) -> dict[str, Array]:
    """By link: its pose T_goal_link, shape (4, 4), seen from the one link of a goal, of all that are kept at one; mostly none.

    Each has joints of its own, and so has the goal's link beside them. It may be fixed to a link that a constraint names.
    """
    if not isinstance(targets, dict) or len(targets) > 1 or all(keep.relative_to is None for keep in keeps):
        return {}
    link = next(iter(targets))
    seen, found = {tree.link_row[link]: inverse(tree.link_offset[link])}, {}  # frames of joints, seen from the goal's link
    for keep in keeps * len(keeps):  # of three hands the third may be kept relative to the second
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
    """The free goals, or more, that keep the constraints of a request; or why there are none.

    free: which of the configurations given are free, shape (n,).
    """
    first = _goals_with(request, targets, free)
    if isinstance(first, Plan) or request.narrow is None:
        return first
    goals = _kept(first, request)
    if goals is None and isinstance(targets, dict):
        goals = next(_of_more(request, targets, free), None)
    if goals is None:
        return no_plan(request.tree, PlanStatus.GOAL_OUTSIDE, violations(request.keeps, request.tree, first.q[0]))
    return goals


def _goals_with(request: Request, targets: Targets, free: NDArray[np.bool_]) -> Goals | Plan:
    """The free goals with a pose for each link beside the goal's. What the task leaves free is as some solutions have it."""
    beside = request.beside
    if not beside or not isinstance(targets, dict):
        return free_goals(request, targets, free)
    link, poses = next((link, T.reshape(-1, 4, 4)) for link, T in targets.items())
    of = np.arange(len(poses))
    if any(as_task(request.task).slack):
        reached = [poses_reached(request, {**beside, link: T}, link, _MAX_POSES) for T in poses]
        if any(map(len, reached)):  # else the task's own inverse kinematics says why
            of, poses = np.repeat(of, [len(T) for T in reached]), np.concatenate(reached)
            request = request._replace(task="pose")
    goals = free_goals(request, {link: poses, **{name: poses @ T for name, T in beside.items()}}, free)
    return goals._replace(of=of[goals.of]) if isinstance(goals, Goals) else goals


def _of_more(request: Request, targets: dict[str, Array], free: NDArray[np.bool_]) -> Iterator[Goals]:
    """The goals that keep the constraints, with free turns chosen so, and of more configurations."""
    link, T = next(iter(targets.items()))
    ways = [(targets, request)]
    if T.ndim == 3:
        for keep in (each for each in request.keeps if each.link == link and each.relative_to is None and not each.towards):
            found = [turned_onto(keep, pose, as_task(request.task)) for pose in T]
            if all(each is not None for each in found):
                poses, tasks = zip(*found, strict=True)
                ways.insert(0, ({link: np.array(poses)}, request._replace(task=tasks[0])))
    for each, asked in ways:
        more = _goals_with(asked._replace(spread=_MORE * SPREAD), each, free)
        goals = None if isinstance(more, Plan) else _kept(more, request)
        if goals is not None:
            yield goals


def _kept(goals: Goals, request: Request) -> Goals | None:
    """Those of the goals that keep the constraints; None if there are none."""
    kept = are_kept(request.narrow, request.tree, goals.q, goals.q)
    return Goals(goals.q[kept], goals.of[kept]) if kept.any() else None


def turned_onto(keep: Keep, T: Array, task: Task) -> tuple[Array, Task] | None:
    """A pose that fulfils a task at T, shape (4, 4), with an orientation that a constraint keeps, if there is one; and its task.

    None if the task leaves no turn free, or the constraint keeps none.
    """
    turns_free = np.isinf(task.slack[3:]).tolist()
    if keep.task.slack[3] == _FREE or not any(turns_free):
        return None
    R, kept, position = T[:3, :3], keep.pose[:3, :3], task.slack[:3]
    axis = np.array(keep.task.axis)
    if all(turns_free):
        if keep.keeps_axis:
            return _posed(T, shortest_turn(R @ axis, kept @ axis) @ R), Task((*position, 0.0, 0.0, _FREE), keep.task.axis)
        return _posed(T, kept), Task((*position, 0.0, 0.0, 0.0))
    if keep.keeps_axis:
        return None
    axis = np.array(task.axis)
    return _posed(T, shortest_turn(kept @ axis, R @ axis) @ kept), Task((*position, 0.0, 0.0, 0.0))


def shortest_turn(a: Array, b: Array) -> Array:
    """The rotation by the least angle that brings a direction to another, shape (3, 3); Rodrigues' formula without the angle."""
    v, c = np.cross(a, b).astype(np.float64), float(a @ b)
    if 1.0 + c < _OPPOSITE:
        n = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return 2.0 * np.outer(n, n).astype(np.float64) / float(n @ n) - np.eye(3)
    K = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + K + K @ K / (1.0 + c)


def _posed(T: Array, R: Array) -> Array:
    posed = T.copy()
    posed[:3, :3] = R
    return posed
