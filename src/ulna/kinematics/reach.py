"""Computes bounds on the reach of an arm, to prove that targets are out of reach.

1. Choose a point on each revolute axis. A joint rotates about its axis, so the distance between the points of two consecutive
   axes is the same in every configuration. With a prismatic joint between them, take its maximum over the joint's range.
2. The path from the first point to the last along these segments is never shorter than the straight line. So |p_last - p_first|
   is at most their sum, and at least the longest minus all others. The points are chosen to make the sum small. Each in turn is
   placed where the path across its axis is shortest (unfolded about the axis, like a ray at a mirror).
3. The first point is fixed in the base. The last is fixed in the end's frame, so the target pose determines its position. For a
   position-only target, one more segment leads from it to the end's origin.
4. Every sum and difference has an error of a few roundings of its largest length. So a difference below _ROUNDING times the sum
   of all lengths proves nothing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.kernels.layout import COLUMN, KIND, OFFSET, PRISMATIC, RATIO, REVOLUTE
from ulna.kinematics.tree import row_pose

Array = NDArray[np.float64]
_SWEEPS = 60
_ROUNDING = 1e-9
_ENDLESS = 1e100  # m: a larger length has no finite square


@dataclass(frozen=True, eq=False)
class Reach:
    """Bounds on the distance [m] of two points of an arm: ``base_point``, and ``end_point`` in the end's frame.

    The distance of ``end_point`` is at least ``min_distance`` and at most ``max_distance``. That of the end's origin is at
    least ``min_origin_distance`` and at most ``max_origin_distance``. ``lengths`` is the sum of all lengths in these bounds, for
    rounding.
    """

    base_point: Array
    end_point: Array
    min_distance: float
    max_distance: float
    min_origin_distance: float
    max_origin_distance: float
    lengths: float

    def distance(self, targets: Array, *, position_only: bool) -> tuple[Array, float, float]:
        """The distance from ``base_point`` that each target (n, 4, 4) requires [m], and its minimum and maximum."""
        if position_only:
            points, min_distance, max_distance = targets[:, :3, 3], self.min_origin_distance, self.max_origin_distance
        else:
            points, min_distance, max_distance = (
                targets[:, :3, :3] @ self.end_point + targets[:, :3, 3],
                self.min_distance,
                self.max_distance,
            )
        return np.linalg.norm(points - self.base_point, axis=-1), min_distance, max_distance

    def excess(self, targets: Array, *, position_only: bool) -> Array:
        """The distance by which each target (n, 4, 4) is provably out of reach, or inside the hole [m]."""
        distance, min_distance, max_distance = self.distance(targets, position_only=position_only)
        excess = np.maximum(distance - max_distance, min_distance - distance)
        return np.where(excess > _ROUNDING * (self.lengths + np.linalg.norm(targets[:, :3, 3], axis=-1)), excess, 0.0)


def reach_of(chain: Array, lower: Array, upper: Array) -> Reach | None:
    """The reach of a chain within its limits; None without a revolute joint, or with an unlimited prismatic one."""
    links = _links(chain, lower, upper)
    if links is None:
        return None
    s = np.zeros(len(links) - 1)  # the position of each axis' point along the axis
    for _ in range(_SWEEPS):
        for k in range(1, len(s) - 1):
            s[k] = _shortest_over_axis(links[k].in_second_frame(s[k - 1]), links[k + 1].in_first_frame(s[k + 1]))
        if len(s) > 1:
            s[0], s[-1] = links[1].in_first_frame(s[1])[0], links[-2].in_second_frame(s[-2])[0]
    segments = [links[k].lengths(s[k - 1], s[k]) for k in range(1, len(s))]
    base, end = links[0], links[-1]
    min_distance, max_distance = _range([*segments, (0.0, base.spread), (0.0, end.spread)])
    base_point = base.middle + s[0] * base.axis
    end_point = -(end.rotation.T @ (end.middle - s[-1] * np.array([0.0, 0.0, 1.0])))
    tail = (float(np.linalg.norm(end_point)) - end.spread, float(np.linalg.norm(end_point)) + end.spread)
    min_origin_distance, max_origin_distance = _range([*segments, (0.0, base.spread), (max(0.0, tail[0]), tail[1])])
    lengths = sum(float(np.linalg.norm(link.corners, axis=1).max()) for link in links) + float(np.abs(s).sum())
    return Reach(base_point, end_point, min_distance, max_distance, min_origin_distance, max_origin_distance, lengths)


@dataclass(frozen=True, eq=False)
class _Link:
    """The transform from one axis (z of its frame) to the next, with prismatic joints at mid-range.

    Attributes:
        middle: Its translation.
        rotation: Its rotation matrix.
        corners: The translation at every combination of the prismatic joints' limits, (m, 3).
        spread: The maximum distance of the corners from ``middle``.
    """

    middle: Array
    rotation: Array
    corners: Array
    spread: float

    @property
    def axis(self) -> Array:
        return self.rotation[:, 2]

    def in_second_frame(self, s: float) -> tuple[float, float]:
        """The cylindrical coordinates of point s of the first axis in the frame of the second: z, radius."""
        p = self.rotation.T @ (np.array([0.0, 0.0, s]) - self.middle)
        return p[2], float(np.hypot(p[0], p[1]))

    def in_first_frame(self, s: float) -> tuple[float, float]:
        """The cylindrical coordinates of point s of the second axis in the frame of the first: z, radius."""
        p = self.middle + s * self.axis
        return p[2], float(np.hypot(p[0], p[1]))

    def lengths(self, s_near: float, s_far: float) -> tuple[float, float]:
        """The minimum and the maximum distance between a point of the first axis and one of the second."""
        differences = self.corners + s_far * self.axis - np.array([0.0, 0.0, s_near])
        largest = float(np.linalg.norm(differences, axis=1).max())
        middle = float(np.linalg.norm(self.middle + s_far * self.axis - np.array([0.0, 0.0, s_near])))
        return (max(0.0, middle - self.spread), largest)


def _shortest_over_axis(p: tuple[float, float], q: tuple[float, float]) -> float:
    """The point of an axis at which the path from p over the axis to q is shortest.

    Both points are given by z along the axis and radius.
    """
    radii = p[1] + q[1]
    return (p[0] + q[0]) / 2 if radii < 1e-12 else (p[0] * q[1] + q[0] * p[1]) / radii


def _range(segments: list[tuple[float, float]]) -> tuple[float, float]:
    """The minimum and the maximum distance between the ends of a path of segments with bounded lengths."""
    longest = sum(largest for _, largest in segments)
    shortest = max(shortest - (longest - largest) for shortest, largest in segments)
    return max(0.0, shortest), longest


def _links(chain: Array, lower: Array, upper: Array) -> list[_Link] | None:
    """The transforms from the base to the first revolute axis, from each to the next, and to the end."""
    links, pose, slides = [], np.eye(4), []
    for row in chain:
        pose = pose @ row_pose(row)
        if int(row[KIND]) == PRISMATIC:
            column = int(row[COLUMN])
            ends = np.array([lower[column], upper[column]]) * row[RATIO] + row[OFFSET]
            if not (np.abs(ends) < _ENDLESS).all():
                return None
            slides.append(np.outer(ends, pose[:3, 2]))
        elif int(row[KIND]) == REVOLUTE:
            links.append(_link(pose, slides))
            pose, slides = np.eye(4), []
    return [*links, _link(pose, slides)] if links else None


def _link(T: Array, slides: list[Array]) -> _Link:
    corners = T[None, :3, 3]
    for ends in slides:
        corners = (corners[:, None] + ends[None]).reshape(-1, 3)
    middle = corners.mean(axis=0)
    return _Link(middle, T[:3, :3], corners, float(np.linalg.norm(corners - middle, axis=1).max()))
