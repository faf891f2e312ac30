"""One shape of a picture, with its colour. Used by the film, the page and the demo."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import Box, Cylinder
from ulna.robot import Robot
from ulna.viewer.palette import FREE, PALE, STRONG, TOUCHING

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


def collision_boxes(robot: Robot, touching: Collection[str] = ()) -> Iterator[Solid[Box]]:
    """The boxes that stand for the arm, pale, and those whose names are in ``touching`` strong and red."""
    for link in robot.description.links:
        for body in link.collisions:
            if isinstance(body.shape, Box):
                look = (TOUCHING, STRONG) if body.name in touching else (FREE, PALE)
                yield Solid(body.name, link.name, body.pose, body.shape, *look)
