"""Makes the triangles of shapes that a few numbers describe, and the shapes that the page's buttons add."""

from collections.abc import Callable
from typing import Any, NamedTuple

import trimesh

from ulna.description.pose import pose
from ulna.description.shapes import Box, Capsule, Cylinder, Primitive, Sphere


class Looks(NamedTuple):
    """The looks of a kind of shape.

    Attributes:
        triangles: The triangles of a shape, in its own frame.
        new: The shape that the page adds, for an edge [m].
    """

    triangles: Callable[[Any], trimesh.Trimesh]
    new: Callable[[float], Primitive]


LOOKS: dict[type, Looks] = {
    Box: Looks(
        lambda box: trimesh.creation.box(box.extents),
        lambda edge: Box((edge, edge, edge)),
    ),
    Sphere: Looks(
        lambda ball: trimesh.creation.icosphere(subdivisions=3, radius=ball.radius),
        lambda edge: Sphere(round(edge / 2, 4)),
    ),
    Cylinder: Looks(
        lambda rod: trimesh.creation.cylinder(rod.radius, rod.length, sections=48),
        lambda edge: Cylinder(round(edge / 2, 4), edge),
    ),
    Capsule: Looks(
        lambda rod: trimesh.creation.capsule(rod.length, rod.radius, transform=pose((0.0, 0.0, -rod.length / 2))),
        lambda edge: Capsule(round(edge / 4, 4), edge),
    ),
}


def primitive_triangles(shape: Primitive) -> trimesh.Trimesh:
    """The triangles of a shape, in its own frame."""
    return next(looks.triangles for kind, looks in LOOKS.items() if isinstance(shape, kind))(shape)
