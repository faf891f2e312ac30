"""Colors (red, green, blue in 0..255) and opacities of everything drawn, and a shape with its pose and color.

Free shapes and shapes in contact also differ in lightness or opacity, for people who cannot distinguish red from green.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import Box, Capsule, Cylinder, Sphere
from ulna.robot import Robot

Color = tuple[int, int, int]

GREEN: Color = (40, 180, 75)  # collision-free
RED: Color = (225, 45, 45)  # in collision, or a target is not reached
STOPPED: Color = (225, 140, 20)  # the hand stops before a collision, or a limit slows it
UNKNOWN: Color = (150, 150, 150)  # not checked
INK: Color = (40, 45, 52)  # text
SLATE: Color = (95, 105, 120)  # lines, on light and on dark pages
FREE: Color = (90, 140, 220)  # collision shapes of the robot
TOUCHING: Color = RED
TRAIL: Color = (0, 150, 165)  # the path of the hand along a plan
MOVABLE: Color = (240, 170, 40)  # obstacles
OBSTACLES: tuple[Color, ...] = (
    MOVABLE,
    (178, 143, 220),
    (84, 182, 170),
    (206, 152, 104),
    (205, 190, 90),
    (222, 144, 186),
)  # obstacles get them in this order, on the page and in a film; red is reserved for contacts
AXES: dict[str, Color] = {
    "x": (215, 55, 75),
    "y": (38, 128, 56),
    "z": (28, 113, 216),
}  # buttons with white letters, on light and on dark pages
GROUND: Color = (150, 160, 172)  # half-spaces
CURVES: tuple[Color, ...] = (
    (0, 120, 185),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (40, 150, 210),
    (176, 130, 0),
    (120, 94, 240),
    (110, 110, 110),
)  # joints in a plot; color-blind people can distinguish them. Source: M. Okabe and K. Ito, 2008
FLOOR_CELLS: Color = (148, 156, 168)  # thin lines of the floor, for light and dark pages: all browsers get the same
FLOOR_SECTIONS: Color = (124, 132, 145)  # thick lines of the floor
SKY: tuple[Color, Color] = ((249, 250, 252), (223, 227, 233))  # from the upper edge of a light page to the lower
TO_SUN = (0.9, 0.25, 1.5)  # the direction to the sun, on the page and in a film
PALE, STRONG = 0.2, 0.75  # opacities of the robot's collision shapes: free, in contact
FAINT = 0.1  # opacity of the shape nearest to an obstacle, if the others are hidden
TINT = 0.7  # opacity of the red over a link in contact
HOLLOW = 0.35  # opacity of a mark in the scene, unless it shows a contact or a stop

ShapeT = TypeVar("ShapeT", Box, Capsule, Cylinder, Sphere)


def is_in_the_way(color: Color) -> bool:
    """Whether a color stands for a contact or a stop. Marks of these colors are full, all others hollow."""
    return color in (RED, STOPPED)


@dataclass(frozen=True, eq=False)
class Solid(Generic[ShapeT]):
    """A shape drawn on a link.

    Attributes:
        name: Its name, the same on the page, in RViz and in a film.
        link: The link with which it moves.
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


def collision_solids(robot: Robot, touching: Collection[str] = ()) -> Iterator[Solid[Any]]:
    """The collision shapes of a robot but meshes: pale blue, or strong red if their names are in ``touching``."""
    for link in robot.description.links:
        for body in link.collisions:
            if isinstance(body.shape, Box | Capsule | Cylinder | Sphere):
                look = (TOUCHING, STRONG) if body.name in touching else (FREE, PALE)
                yield Solid[Any](body.name, link.name, body.pose, body.shape, *look)
