"""Records a robot that moves along rows of q among obstacles, with a fixed camera."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Report
from ulna.collision.world import World
from ulna.description.shapes import Box, HalfSpace
from ulna.errors import GeometryError
from ulna.robot import Robot
from ulna.viewer.film.camera import Camera
from ulna.viewer.film.model import BoundingBall, Model
from ulna.viewer.film.painter import Picture
from ulna.viewer.film.record import TURN_FROM, Form, Tell, ground_of, report_nothing, write_pictures
from ulna.viewer.palette import GROUND, MOVABLE, TOUCHING
from ulna.viewer.solid import Solid, collision_boxes
from ulna.viewer.visuals import triangles

Array = NDArray[np.float64]
_FAR = 4.0  # in radii of the robot: the picture does not include obstacles farther away
_SLAB = Box((4.0, 4.0, 0.004))  # drawn for a half-space [m]


def record_moving(
    form: Form, robot: Robot, path: Array, world: World, *, boxes: bool = True, tell: Tell = report_nothing
) -> tuple[str, ...]:
    """Record a robot along rows of q, evenly spaced in time; shapes that touch are red.

    Args:
        form: The format of the file. A single picture shows the first row.
        robot: The robot.
        path: Joint positions [rad or m], shape (n, n_dof).
        world: The obstacles.
        boxes: Show its collision boxes.
        tell: Called with the number of pictures done so far.

    Returns:
        The meshes that could not be shown, each with the reason.

    Raises:
        FileError: The file cannot be written.
    """
    shots = [(q, _solids(robot, q, world, boxes=boxes)) for q in _along(path, form.n_frames)]
    model = Model(robot, shots[0][1])
    balls = [model.bounding_ball(q) for q in _along(path, min(len(path), 16))]
    ball = _around(balls, world)
    camera = Camera.around(ball.centre, ball.radius, TURN_FROM, form.size[0] / form.size[1])
    write_pictures(form, model, [Picture(q, camera, solids) for q, solids in shots], ground_of(ball), tell)
    return model.missing


def _along(path: Array, n: int) -> Iterator[Array]:
    """n configurations at even times from the first row to the last, linear between rows."""
    for place in np.linspace(0.0, len(path) - 1, n) if n > 1 else [0.0]:
        k = min(int(place), max(len(path) - 2, 0))
        yield path[k] + (place - k) * (path[min(k + 1, len(path) - 1)] - path[k])


def _solids(robot: Robot, q: Array, world: World, *, boxes: bool) -> tuple[Solid, ...]:
    """The robot's boxes and the obstacles; red if they touch."""
    report = _report(robot, q, world)
    hit = {pair.name_b for pair in report.pairs if pair.link_b is None and pair.signed_distance <= 0.0}
    panes = collision_boxes(robot, report.touching) if boxes else ()
    return (*panes, *(_obstacle(robot, name, shape, T, touching=name in hit) for name, shape, T in world.items()))


def _report(robot: Robot, q: Array, world: World) -> Report:
    """The collision report; an empty one if the robot's shapes cannot be checked."""
    try:
        return robot.check_collision(q, world)
    except GeometryError:
        return Report(())


def _obstacle(robot: Robot, name: str, shape: object, T: Array, *, touching: bool) -> Solid:
    """An obstacle as it is drawn; a half-space is drawn as a slab under its surface."""
    color = TOUCHING if touching else MOVABLE
    if isinstance(shape, HalfSpace):
        T = T.copy()
        T[:3, 3] -= T[:3, 2] * _SLAB.extents[2] / 2
        shape, color = _SLAB, color if touching else GROUND
    return Solid(f"obstacle {name}", robot.base, T, shape, color)  # type: ignore[type-var]


def _around(balls: list[BoundingBall], world: World) -> BoundingBall:
    """A ball around the robot in all its configurations, and the obstacles near it."""
    low = np.min([ball.centre - ball.radius for ball in balls], axis=0)
    high = np.max([ball.centre + ball.radius for ball in balls], axis=0)
    solids = [
        triangles(shape).vertices @ T[:3, :3].T + T[:3, 3] for _, shape, T in world.items() if not isinstance(shape, HalfSpace)
    ]
    near = [points for points in solids if np.abs(points - (low + high) / 2).max() <= _FAR * np.max(high - low) / 2]
    corners = np.vstack([low, high, *near])
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    reach = [np.linalg.norm(ball.centre - centre) + ball.radius for ball in balls]
    reach += [np.linalg.norm(points - centre, axis=1).max() for points in near]
    return BoundingBall(centre, float(max(reach)), min(ball.lowest for ball in balls))
