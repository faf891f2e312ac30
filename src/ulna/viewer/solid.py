"""A shape with its pose and colour, as pictures show it."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import Box, Cylinder
from ulna.robot import Robot
from ulna.viewer.palette import FREE, PALE, STRONG, TOUCHING, Color

ShapeT = TypeVar("ShapeT", Box, Cylinder)


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
