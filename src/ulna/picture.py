"""What every screen draws of the demo: solids with their names, places and colours. The browser, RViz and videos show these."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.report import Report
from ulna.demo import BOX, BOX_NAME, LIGHT, LIGHT_POSITION, RED, light_color
from ulna.model.pose import pose
from ulna.model.shapes import Box, Cylinder
from ulna.robot import Robot
from ulna.robots import panda

FREE, TOUCHING, MOVABLE, INK = (90, 140, 220), RED, (240, 170, 40), (40, 45, 52)
PALE, STRONG = 0.2, 0.75  # opacities: the arm is seen through its boxes, a touching box is not overlooked
WORD_POSITION = (0.0, 0.0, -LIGHT.length)  # of the word beside the light, in the light's frame [m]


ShapeT = TypeVar("ShapeT", Box, Cylinder)


@dataclass(frozen=True, eq=False)
class Solid(Generic[ShapeT]):
    """One shape of the picture.

    Attributes:
        name: What it is called on every screen.
        link: The link that it moves with.
        pose: T_link_solid, shape (4, 4).
        shape: Its shape.
        color: Red, green, blue in 0..255.
        opacity: From 0, not seen, to 1.
        glows: True if it shines by itself.
    """

    name: str
    link: str
    pose: NDArray[np.float64]
    shape: ShapeT
    color: tuple[int, int, int]
    opacity: float = 1.0
    glows: bool = False


def arm_boxes(robot: Robot, touching: Collection[str] = ()) -> Iterator[Solid[Box]]:
    """The boxes that stand for the arm, pale, and those whose names are in ``touching`` strong and red."""
    for link in robot.description.links:
        for body in link.collisions:
            if isinstance(body.shape, Box):
                look = (TOUCHING, STRONG) if body.name in touching else (FREE, PALE)
                yield Solid(body.name, link.name, body.pose, body.shape, *look)


def standing_boxes(robot: Robot, q: ArrayLike) -> Iterator[Solid[Box]]:
    """The same boxes, pale, where they stand in the base at q."""
    places = dict(zip(robot.link_names, robot.link_poses(q), strict=True))
    for solid in arm_boxes(robot):
        yield replace(solid, link=robot.base, pose=places[solid.link] @ solid.pose)


def light(robot: Robot, report: Report) -> Solid[Cylinder]:
    """The light, red or green; the word beside it is ``str(report)``."""
    return Solid("light", robot.base, pose(LIGHT_POSITION), LIGHT, light_color(report), glows=True)


def movable_box(robot: Robot, T_base_box: NDArray[np.float64]) -> Solid[Box]:
    """The box that a person drags."""
    return Solid(BOX_NAME, robot.base, T_base_box, BOX, MOVABLE)


def joint_positions(robot: Robot, q: ArrayLike) -> dict[str, float]:
    """The position of each joint by its name [rad or m]; the Panda's fingers, which its description does not move, follow."""
    positions = dict(zip(robot.joint_names, map(float, np.asarray(q)), strict=True))
    return positions | (dict.fromkeys(panda.FINGER_JOINTS, panda.FINGER_POSITION) if robot.name == "panda" else {})
