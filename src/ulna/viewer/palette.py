"""Colors (red, green, blue in 0..255) and opacities of everything drawn, and a shape with its pose and color.

Free and touching shapes also differ in lightness or opacity, for people who cannot distinguish red from green.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import Box, Cylinder
from ulna.robot import Robot

Color = tuple[int, int, int]

GREEN: Color = (40, 180, 75)  # nothing touches
RED: Color = (225, 45, 45)  # something touches, or a target is not reached
STOPPED: Color = (225, 140, 20)  # the hand stops before a collision, or something limits it
UNKNOWN: Color = (150, 150, 150)  # not checked
INK: Color = (40, 45, 52)  # words
SLATE: Color = (95, 105, 120)  # lines, on a light page and on a dark one
FREE: Color = (90, 140, 220)  # collision shapes of the robot
TOUCHING: Color = RED
TRAIL: Color = (0, 150, 165)  # the way of the hand along a plan
MOVABLE: Color = (240, 170, 40)  # obstacles
OBSTACLES: tuple[Color, ...] = (
    MOVABLE,
    (178, 143, 220),
    (84, 182, 170),
    (206, 152, 104),
    (205, 190, 90),
    (222, 144, 186),
)  # by their order, on the page and in a film; red is not among them
AXES: dict[str, Color] = {
    "x": (215, 55, 75),
    "y": (38, 128, 56),
    "z": (28, 113, 216),
}  # of buttons, with white letters, on a light page and on a dark one
GROUND: Color = (150, 160, 172)  # half-spaces among them
CURVES: tuple[Color, ...] = (
    (0, 120, 185),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (40, 150, 210),
    (176, 130, 0),
    (120, 94, 240),
    (110, 110, 110),
)  # of joints in a plot, which color-blind people can distinguish; after M. Okabe and K. Ito, 2008
FLOOR_CELLS: Color = (148, 156, 168)  # the floor's thin lines: all tabs have the same, on light pages and on dark ones
FLOOR_SECTIONS: Color = (124, 132, 145)
SKY: tuple[Color, Color] = ((249, 250, 252), (223, 227, 233))  # from the upper edge of a light page to the lower
TO_SUN = (0.9, 0.25, 1.5)  # the direction to the sun, on the page and in a film
PALE, STRONG = 0.2, 0.75  # opacities of the robot's collision shapes: free, touching
FAINT = 0.1  # of the robot's shape to which the distance is shown
TINT = 0.7  # of the red over a link that touches
HOLLOW = 0.35  # of a mark in the scene, unless something is in the way

ShapeT = TypeVar("ShapeT", Box, Cylinder)


def is_in_the_way(color: Color) -> bool:
    """Whether a color says that something touches, or stops an arm: signs of it are full, all others hollow."""
    return color in (RED, STOPPED)


@dataclass(frozen=True, eq=False)
class Solid(Generic[ShapeT]):
    """A shape that is drawn on a link.

    Attributes:
        name: Its name, the same in the page, in RViz and in a film.
        link: The link that it moves with.
        pose: T_link_solid, shape (4, 4).
        shape: Its shape.
        color: Red, green, blue in 0..255.
        opacity: From 0, invisible, to 1.
        glows: Whether it emits light.
    """

    name: str
    link: str
    pose: NDArray[np.float64]
    shape: ShapeT
    color: Color
    opacity: float = 1.0
    glows: bool = False


def collision_boxes(robot: Robot, touching: Collection[str] = ()) -> Iterator[Solid[Box]]:
    """The collision boxes of a robot: pale, or strong and red if their names are in ``touching``."""
    for link in robot.description.links:
        for body in link.collisions:
            if isinstance(body.shape, Box):
                look = (TOUCHING, STRONG) if body.name in touching else (FREE, PALE)
                yield Solid(body.name, link.name, body.pose, body.shape, *look)
