"""Computes q, the pose of the box, and the contacts at each moment of the demo's film.

The box goes round the arm once and touches it at six places, from the hand to the base: it approaches, touches, slides along and
moves away. The places are relative to the moving arm, so the contacts are the same for any length of the film.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sin

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.demo.drawing import standing_boxes
from ulna.demo.scenario import BOX, BOX_START, Demo
from ulna.description.pose import pose
from ulna.description.shapes import Box

NEAR, DEEP = 0.12, -0.035  # [m] distances of the box from the arm: before and after a contact, and during it


@dataclass(frozen=True)
class Visit:
    """A contact: one of the arm's boxes, the direction of approach, and the way [m] along it, both in the base's axes."""

    box: str
    side: tuple[float, float, float]
    slide: tuple[float, float, float]


VISITS = (
    Visit("box 12", (1.0, 0.0, -0.4), (0.0, 0.0, 0.05)),
    Visit("box 11", (1.0, 0.5, 0.3), (0.0, 0.0, 0.06)),
    Visit("box 8", (0.2, 0.3, 1.0), (-0.06, 0.0, 0.0)),
    Visit("box 7", (-1.0, 0.4, 0.3), (0.0, 0.0, -0.06)),
    Visit("box 5", (-0.2, 1.0, 0.2), (0.0, 0.0, -0.06)),
    Visit("box 1", (1.0, 0.2, 0.3), (0.0, -0.06, 0.0)),
)


@dataclass(frozen=True, eq=False)
class Moment:
    """The demo at one time.

    Attributes:
        q: Joint positions of the arm [rad], shape (n_dof,).
        T_base_box: The pose of the box, shape (4, 4).
        report: The boxes of the arm that it touches.
    """

    q: NDArray[np.float64]
    T_base_box: NDArray[np.float64]
    report: Report


class Script:
    """The demo's film of a given length."""

    def __init__(self, demo: Demo, seconds: float) -> None:
        self.demo, self.seconds = demo, seconds
        self._knots = self._make_knots()

    def moment(self, time: float) -> Moment:
        """The demo at a time [s]."""
        q, T = self.demo.trajectory.at(time), self.box_pose(time / self.seconds)
        self.demo.move_box(T)
        return Moment(q, T, self.demo.check(q))

    def moments(self, rate: float) -> Iterator[Moment]:
        """All moments, ``rate`` a second."""
        for k in range(max(round(self.seconds * rate), 1)):
            yield self.moment(k / rate)

    def box_pose(self, part: float) -> NDArray[np.float64]:
        """T_base_box, shape (4, 4), at a part of the time, 0 to 1; at 1 the box is back at its start."""
        T = self._turned(part)
        T[:3, 3] = _on_curve(self._knots, part)
        return T

    def _make_knots(self) -> NDArray[np.float64]:
        """The positions [m] of the box at even times, shape (n, 3): its start, and four for each visit."""
        n = 1 + 4 * len(VISITS)
        knots = [np.array(BOX_START)]
        for visit in VISITS:
            middle = (len(knots) + 1.5) / n
            for distance, slid in ((NEAR, -0.5), (DEEP, -0.5), (DEEP, 0.5), (NEAR, 0.5)):
                knots.append(self._beside(visit, distance, middle) + slid * np.array(visit.slide))
        return np.array(knots)

    def _beside(self, visit: Visit, distance: float, part: float) -> NDArray[np.float64]:
        """The centre of the movable box [m] at a distance [m] from the visited box, along the direction of approach."""
        q = self.demo.trajectory.at(part * self.seconds)
        (visited,) = (solid for solid in standing_boxes(self.demo.robot, q) if solid.name == visit.box)
        side = np.array(visit.side) / np.linalg.norm(visit.side)
        reach = _reach(visited.pose, visited.shape, side) + _reach(self._turned(part), BOX, side)
        return visited.pose[:3, 3] + (reach + distance) * side

    @staticmethod
    def _turned(part: float) -> NDArray[np.float64]:
        """The orientation of the box at a part of the time, as a pose: one turn about z, and a small oscillation."""
        return pose((0, 0, 0), (0.35 * sin(6 * pi * part), 0.0, 2 * pi * part))


def _reach(T: NDArray[np.float64], box: Box, direction: NDArray[np.float64]) -> float:
    """The half extent [m] of a box along a unit vector."""
    return float(np.abs(direction @ T[:3, :3]) @ box.half_extents)


def _on_curve(knots: NDArray[np.float64], part: float) -> NDArray[np.float64]:
    """A closed smooth curve through all knots, at a part of its time, 0 to 1.

    Source: Catmull and Rom, A class of local interpolating splines (1974).
    """
    n = len(knots)
    k, s = int(part * n), part * n % 1.0
    a, b, c, d = (knots[(k + i) % n] for i in (-1, 0, 1, 2))
    return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)))
