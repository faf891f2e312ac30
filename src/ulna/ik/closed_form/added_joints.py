"""Adds joints to an arm of fewer than six, to make it an arm of six.

An added joint is *free* if the task leaves its rotation open: three about the link's origin for a position, one about the axis of
a pointing task. Otherwise it is *at rest*: a solution of the six joints is a solution of the arm if the added joint is at 0. The
added joints follow the arm's own joints, where they complete a family:

1. One added joint at rest intersects the last axis. Two points of intersection are tried. At the first, the last axis is nearest
   to the axis before it: if these two axes intersect, the three axes are a wrist. The second is the projection of the link's
   origin onto the last axis.
2. Two at rest intersect the last axis: these three are a wrist. Three are a wrist at the link's origin, or anywhere on the link.
   The wrist is not on a revolute axis before it, since that axis would not move it; it is placed far away from it instead.
3. A wrist is singular where its first and last axes are parallel. The angles between these two and the middle axis are made to
   differ, so that they are never parallel. If the three lie in a plane, the wrist's two branches coincide. Two added joints at
   rest never lie so.
4. For five joints whose last three are a wrist, one joint at rest comes before them. Its axis intersects the first axis, or is
   far from it if the first is parallel to the second.
5. The axes of a planar arm are parallel. One joint at rest comes before them, perpendicular and so far away that its two branches
   never coincide. The arm then belongs to the family of three parallel axes.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.pose import inverse
from ulna.ik.closed_form.axes import N_AXES, Axes, frame_along, normal_to, table_of_rows
from ulna.ik.task import Task
from ulna.kernels.ik.search_layout import POINTING, WHOLE_POSE
from ulna.kernels.layout import FIXED, PRISMATIC, REVOLUTE

Array = NDArray[np.float64]
Line = tuple[Array, Array]  # a point and a direction
_POSITION = Task.position().slack
_PARALLEL = 1e-12  # rad
_NEAR = 0.03  # of the unit
_MIN_JOINTS = {0: 3, 1: 5, 3: 3}  # joints that an arm needs, by the number of free ones
_PLANAR = {0: (2, 3), 3: (2,)}  # the numbers of joints of a planar arm
_FAR = 3.0  # units from the arm to an axis before it: more than the arm's reach


def free_turns(task: Task) -> int | None:
    """The number of rotations at the end that a task leaves free; None for a task without a closed form."""
    if task.kind == WHOLE_POSE:
        return 0
    if task.kind == POINTING:
        return 1 if not any(task.slack[:5]) else None
    return 3 if task.slack == _POSITION else None


def six_joint_arms(axes: Axes, n_free: int) -> list[Axes]:
    """Arms of six joints equivalent to an arm with added joints, the likeliest to have a closed form first."""
    if len(axes.directions) in _PLANAR.get(n_free, ()) and _is_planar(axes):
        return [_complete_planar(axes, n_free)]
    return [arm for order in _orders(axes) for arm in _complete(order, n_free)]


def _complete(axes: Axes, n_free: int) -> list[Axes]:
    n = len(axes.directions)
    if (n == N_AXES and not n_free) or n + n_free > N_AXES or n < _MIN_JOINTS[n_free]:
        return [] if n_free or n != N_AXES else [axes]
    origin, last = axes.end[:3, 3], axes.directions[-1]
    if n_free == 1:
        return [_add_joints(axes, [(origin, axes.end[:3, 2])])]
    if n + 3 == N_AXES:
        normal = normal_to(last)
        third: Array = np.cross(normal, last).astype(np.float64)
        point = origin + normal * (axes.unit if not n_free and _is_on_axis(axes, -1, origin) else 0.0)
        return [_add_joints(axes, [(point, normal), (point, last), (point, third)])]
    return [] if n_free or axes.slides[-1] else _add_one_or_two(axes)


def _add_one_or_two(axes: Axes) -> list[Axes]:
    """An arm of four or five joints with one or two joints at rest added."""
    origin, last = axes.end[:3, 3], axes.directions[-1]
    point_at_height = axes.points[-1] + last * ((origin - axes.points[-1]) @ last)
    if len(axes.directions) + 2 == N_AXES:
        point_at_height = point_at_height + last * (axes.unit if _is_on_axis(axes, -2, point_at_height) else 0.0)
        fifth = normal_to(last)
        return [_add_joints(axes, [(point_at_height, fifth), (point_at_height, (fifth + np.cross(last, fifth)) / np.sqrt(2.0))])]
    intersection = _nearest_to_previous(axes)
    is_wrist = not axes.slides.any() and _is_on_axis(axes, -2, intersection) and _is_on_axis(axes, -3, intersection)
    candidates = [
        _add_joints(axes, [(point, _inclined_direction(last, axes.directions[-2]))]) for point in (intersection, point_at_height)
    ]
    return [_add_joints(axes, [], [_axis_before(axes)]), *candidates] if is_wrist else candidates


def _axis_before(axes: Axes) -> Line:
    """An axis before the first and perpendicular to it.

    It intersects the first axis, or passes it at a distance if the first is parallel to the second.
    """
    h = axes.directions[0]
    normal = normal_to(h)
    is_parallel = np.linalg.norm(np.cross(h, axes.directions[1])) < _PARALLEL
    offset = np.cross(normal, h) if is_parallel else h
    return axes.points[0] - _FAR * axes.unit * offset, normal


def _is_planar(axes: Axes) -> bool:
    """Whether all joints rotate about parallel axes, each at a distance from the axis before it."""
    h = axes.directions
    is_parallel = np.linalg.norm(np.cross(h[:-1], h[1:]), axis=1).max() < _PARALLEL
    return (
        is_parallel and not axes.slides.any() and not any(_is_on_axis(axes, j, point) for j, point in enumerate(axes.points[1:]))
    )


def _complete_planar(axes: Axes, n_free: int) -> Axes:
    """A planar arm of two or three joints with one joint before it, and a wrist at the link's origin."""
    origin, h, first = axes.end[:3, 3], axes.directions[-1], _axis_before(axes)
    normal = normal_to(h)
    third: Array = np.cross(normal, h).astype(np.float64)
    wrist = [(origin, normal), (origin, third)]
    if len(axes.directions) + 3 < N_AXES:
        parallel = origin + normal * (axes.unit if not n_free and _is_on_axis(axes, -1, origin) else 0.0)
        wrist = [(parallel, h), *wrist]
    return _add_joints(axes, wrist, [first])


def _is_on_axis(axes: Axes, j: int, point: Array) -> bool:
    """Whether a point is on a joint's revolute axis, up to a share of the arm's length."""
    return not axes.slides[j] and float(np.linalg.norm(np.cross(axes.directions[j], point - axes.points[j]))) < _NEAR * axes.unit


def _orders(axes: Axes) -> list[Axes]:
    """Equivalent orders of the joints: the given one, and one with prismatic joints moved before parallel revolute ones."""
    h, order = axes.directions, list(range(len(axes.directions)))
    for _ in order:
        for k in range(1, len(order)):
            i, j = order[k - 1], order[k]
            if axes.slides[j] and not axes.slides[i] and np.linalg.norm(np.cross(h[i], h[j])) < _PARALLEL:
                order[k - 1], order[k] = j, i
    if order == list(range(len(order))):
        return [axes]
    other = replace(axes, directions=h[order], points=axes.points[order], slides=axes.slides[order], entries=axes.entries[order])
    return [axes, _add_joints(other, [])]


def _nearest_to_previous(axes: Axes) -> Array:
    """The point of the last axis that is nearest to the axis before it."""
    h, k, difference = axes.directions[-1], axes.directions[-2], axes.points[-2] - axes.points[-1]
    cosine = h @ k
    square = 1.0 - cosine * cosine
    return axes.points[-1] + h * ((difference @ h - cosine * (difference @ k)) / square if square > 1e-12 else 0.0)


def _inclined_direction(h: Array, other: Array) -> Array:
    """A direction whose angle with h is far from the angle of another one with h, and from its supplement."""
    angle = float(np.arctan2(np.linalg.norm(np.cross(h, other)), abs(h @ other)))
    inclination = angle / 2.0 if angle > np.pi / 4 else angle / 2.0 + np.pi / 4
    return np.cos(inclination) * h + np.sin(inclination) * normal_to(h)


def _add_joints(axes: Axes, behind: list[Line], before: Sequence[Line] = ()) -> Axes:
    """Add joints about further lines after the axes, or before them, and make the chain of all joints."""
    n, first, added = len(axes.directions), len(before), [*before, *behind]

    def with_added(rows: NDArray[Any], new: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([new[:first], rows, new[first:]])

    directions, points = (
        with_added(rows, np.array([line[i] for line in added]).reshape(-1, 3))
        for i, rows in ((1, axes.directions), (0, axes.points))
    )
    slides = with_added(axes.slides, np.zeros(len(added), dtype=bool))
    entries = with_added(axes.entries, np.arange(n, n + len(added)))
    rows, frame = [], np.eye(4)
    for point, direction, slide, entry in zip(points, directions, slides, entries, strict=True):
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = frame_along(direction), point
        rows.append([*(inverse(frame) @ own)[:3].ravel(), PRISMATIC if slide else REVOLUTE, entry, 1.0, 0.0])
        frame = own
    rows.append([*(inverse(frame) @ axes.end)[:3].ravel(), FIXED, 0, 1.0, 0.0])
    return replace(axes, directions=directions, points=points, slides=slides, entries=entries, chain=table_of_rows(rows))
