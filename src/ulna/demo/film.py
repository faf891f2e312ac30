"""Records the demo as a video or picture: q, the pose of the box, and the contacts at each moment.

The box circles the arm once and touches it at six places, from the hand to the base. At each place it approaches, touches, slides
and moves away. The places are relative to the moving arm, so a film of any length shows the same contacts.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import atan, pi, sin, tan

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.demo.drawing import WORD_POSITION_IN_BASE, box_handles, light, movable_box, standing_boxes
from ulna.demo.scenario import BOX, BOX_START, Demo
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.painter import Caption, Ground, Picture
from ulna.viewer.film.recording import Form, Tell, report_nothing, write_pictures
from ulna.viewer.film.skin import Model
from ulna.viewer.palette import collision_solids

DEMO_CAMERA = Camera(position=(1.45, 1.35, 0.95), look_at=(0.13, 0.02, 0.45), fov=0.72)  # the box stays in sight
DEMO_GROUND = Ground(middle=(0.1, 0.0, 0.4), radius=1.3)
DEMO_ASPECT = 1.3  # width by height: a narrower picture shows more above and below
NEAR, DEEP = 0.12, -0.035  # [m], distances of the box from the arm: before and after a contact, and during it


@dataclass(frozen=True)
class Visit:
    """A contact: one of the arm's boxes, and the approach direction and sliding path [m] in the base's axes."""

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
    """The state of the demo at one time.

    Attributes:
        q: Joint positions of the arm [rad], shape (n_dof,).
        T_base_box: The pose of the box, shape (4, 4).
        report: The arm's boxes in contact.
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
        """The state of the demo at a time [s]."""
        q, T = self.demo.trajectory.at(time), self.box_pose(time / self.seconds)
        self.demo.move_box(T)
        return Moment(q, T, self.demo.check(q))

    def moments(self, rate: float) -> Iterator[Moment]:
        """All moments, ``rate`` per second."""
        for k in range(max(round(self.seconds * rate), 1)):
            yield self.moment(k / rate)

    def box_pose(self, part: float) -> NDArray[np.float64]:
        """T_base_box, shape (4, 4), at a fraction of the time, 0 to 1; 1 is the start again."""
        T = self._turned(part)
        T[:3, 3] = _on_curve(self._knots, part)
        return T

    def _make_knots(self) -> NDArray[np.float64]:
        """The positions [m] of the box at equal time steps, shape (n, 3): its start, and four for each visit."""
        n = 1 + 4 * len(VISITS)
        knots = [np.array(BOX_START)]
        for visit in VISITS:
            middle = (len(knots) + 1.5) / n
            for distance, slid in ((NEAR, -0.5), (DEEP, -0.5), (DEEP, 0.5), (NEAR, 0.5)):
                knots.append(self._beside(visit, distance, middle) + slid * np.array(visit.slide))
        return np.array(knots)

    def _beside(self, visit: Visit, distance: float, part: float) -> NDArray[np.float64]:
        """The center of the movable box [m] at a distance [m] from the visited box, along the direction of approach."""
        q = self.demo.trajectory.at(part * self.seconds)
        (visited,) = (solid for solid in standing_boxes(self.demo.robot, q) if solid.name == visit.box)
        side = np.array(visit.side) / np.linalg.norm(visit.side)
        reach = _reach(visited.pose, visited.shape, side) + _reach(self._turned(part), BOX, side)
        return visited.pose[:3, 3] + (reach + distance) * side

    @staticmethod
    def _turned(part: float) -> NDArray[np.float64]:
        """The orientation of the box at a fraction of the time: one turn about z, and a small oscillation."""
        return pose((0, 0, 0), (0.35 * sin(6 * pi * part), 0.0, 2 * pi * part))


def _reach(T: NDArray[np.float64], box: Box, direction: NDArray[np.float64]) -> float:
    """The half extent [m] of a box along a unit vector."""
    return float(np.abs(direction @ T[:3, :3]) @ box.half_extents)


def _on_curve(knots: NDArray[np.float64], part: float) -> NDArray[np.float64]:
    """Evaluate a closed smooth curve through all knots at a fraction of its time, 0 to 1.

    Source: Catmull and Rom, A class of local interpolating splines (1974).
    """
    n = len(knots)
    k, s = int(part * n), part * n % 1.0
    a, b, c, d = (knots[(k + i) % n] for i in (-1, 0, 1, 2))
    return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)))


def record_demo(form: Form, at: float | None = None, *, boxes: bool = True, tell: Tell = report_nothing) -> None:
    """Record the demo: the arm repeats its trajectory, the box circles it, the light is red during contacts.

    Args:
        form: The format of the file.
        at: The time [s] of a single picture; by default the first contact.
        boxes: Show the twelve collision boxes of the arm.
        tell: Called with the number of pictures done.
    """
    if at is not None and not form.is_still:
        raise InputError("at", f"is for a single picture, a .png; {form.path.name} shows the whole demo")
    demo = Demo()
    script = Script(demo, form.seconds)
    at = 0.1 * form.seconds if at is None else at
    if not 0.0 <= at <= form.seconds:
        raise InputError("at", f"{at:g} s is not between 0 and {form.seconds:g} s")
    moments = [script.moment(at)] if form.is_still else script.moments(form.rate)
    camera = _widened(DEMO_CAMERA, form.size)
    record_pictures(form, demo.robot, [demo_picture(demo.robot, moment, camera, boxes=boxes) for moment in moments], tell)


def demo_picture(robot: Robot, moment: Moment, camera: Camera, *, boxes: bool = True) -> Picture:
    """One moment of the demo as seen by a camera."""
    panes = tuple(collision_solids(robot, moment.report.touching)) if boxes else ()
    box = movable_box(robot, moment.T_base_box), *box_handles(robot, moment.T_base_box)
    solids = (*panes, *box, light(robot, moment.report))
    return Picture(moment.q, camera, solids, Caption(str(moment.report), WORD_POSITION_IN_BASE))


def record_pictures(form: Form, robot: Robot, pictures: Sequence[Picture], tell: Tell = report_nothing) -> None:
    """Write pictures of the demo into the file of a form."""
    write_pictures(form, Model(robot), pictures, DEMO_GROUND, tell)


def _widened(camera: Camera, size: tuple[int, int]) -> Camera:
    """Widen the camera's field of view for a narrow picture, so that the width of the scene still fits."""
    narrow = max(DEMO_ASPECT * size[1] / size[0], 1.0)
    return replace(camera, fov=2 * atan(narrow * tan(camera.fov / 2)))
