"""Finds goals that keep a motion's constraints: those of a pose whose free turns are used to keep them, and more of them.

What a goal leaves free of a link's orientation, and a constraint of the same link does not, is chosen by the shortest turn. What
the joints leave free, as those of a redundant arm do, is searched: more configurations of the same poses are tried.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.ik.task import Task, as_task
from ulna.planning.goals import SPREAD, Goals, Request, find_goals
from ulna.planning.keep import Keep
from ulna.planning.kept import are_kept, violations
from ulna.planning.plan import Plan, PlanStatus, no_plan
from ulna.planning.targets import Targets

Array = NDArray[np.float64]
_MORE = 16  # times as many configurations of a pose
_FREE = float("inf")
_OPPOSITE = 1e-12  # of 1 + cos: directions between which the shortest turn may be about any axis


def keep_goals(
    first: Goals,
    request: Request,
    targets: Targets,
    fixed: NDArray[np.bool_],
    free: NDArray[np.bool_],
    keeps: tuple[Keep, ...],
    table: Array,
) -> Goals | Plan:
    """Of the goals that ``find_goals`` found, or of more, those that keep the constraints of a table; or why there are none."""
    goals = _kept(first, table, request)
    if goals is None and isinstance(targets, dict):
        goals = next(_of_more(request, targets, fixed, free, keeps, table), None)
    return no_plan(request.tree, PlanStatus.GOAL_OUTSIDE, violations(keeps, request.tree, first.q[0])) if goals is None else goals


def _of_more(
    request: Request, targets: dict[str, Array], fixed: NDArray[np.bool_], free: NDArray[np.bool_], keeps: tuple[Keep, ...],
    table: Array,
) -> Iterator[Goals]:  # fmt: skip
    """The goals that keep the constraints, with free turns chosen so, and of more configurations."""
    link, T = next(iter(targets.items()))
    ways = [(targets, request)]
    if T.ndim == 3:
        for keep in (each for each in keeps if each.link == link and each.relative_to is None and not each.towards):
            found = [turned_onto(keep, pose, as_task(request.task)) for pose in T]
            if all(each is not None for each in found):
                poses, tasks = zip(*found, strict=True)
                ways.insert(0, ({link: np.array(poses)}, request._replace(task=tasks[0])))
    for each, asked in ways:
        more = find_goals(asked._replace(spread=_MORE * SPREAD), each, fixed, free)
        goals = None if isinstance(more, Plan) else _kept(more, table, request)
        if goals is not None:
            yield goals


def _kept(goals: Goals, table: Array, request: Request) -> Goals | None:
    """Those of the goals that keep the constraints; None if there are none."""
    kept = are_kept(table, request.tree, goals.q, goals.q)
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
