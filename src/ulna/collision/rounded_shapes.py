"""Converts shapes to columns of a table: a core, and the radius that rounds it."""

from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from ulna.description.shapes import KINDS, ConvexMesh, HalfSpace, Shape, UnknownShape, kind_of
from ulna.errors import GeometryError, install_command
from ulna.kernels.layout import HALF_SPACE, HULL

NO_VERTICES = np.zeros((0, 3))
_MIN_GAIN = 0.9  # share of the surface of the unrotated box: a rotated frame must save at least the rest


def _advice() -> str:
    hulls, pieces = install_command("hulls"), install_command("decompose")
    return (
        f"ulna.load(..., meshes='hulls') ({hulls}) or meshes='decompose' ({pieces}) puts convex shapes in the place of a "
        "robot's meshes, and so do robot.with_convex_hulls() and ulna view with --meshes"
    )


def shape_columns(shape: Shape | HalfSpace, first_vertex: int = 0) -> tuple[float, ...]:
    """The columns from SHAPE on of a row of a table of bodies.

    Args:
        shape: The body's shape.
        first_vertex: The row of the shape's first vertex (``shape_vertices``) in the table's vertices.

    Raises:
        GeometryError: It is a mesh as a file gives it, which may be concave, or an unknown shape.
    """
    if (kind := kind_of(shape)) is not None:
        x, y, z, radius = kind.core(shape)
        return kind.number, x, y, z, radius, 0, 0, hypot(x, y, z) + radius
    match shape:
        case HalfSpace():
            return HALF_SPACE, 0.0, 0.0, 0.0, 0.0, 0, 0, inf
        case ConvexMesh(vertices=vertices):
            return hull_columns(vertices, first_vertex)
        case UnknownShape(name):
            known = ", ".join(kind.word for kind in KINDS)
            raise GeometryError(f"{name} is not known, so it cannot be checked; {known} and mesh are")
        case _:
            raise GeometryError(f"a {type(shape).__name__} has no collision kernel; {_advice()}")


def hull_columns(vertices: NDArray[np.float64], first_vertex: int) -> tuple[float, ...]:
    """The columns from SHAPE on of a hull of points in its row's frame, shape (n, 3).

    REACH is the distance of the farthest point.
    """
    half_extents = np.abs(vertices).max(axis=0).tolist()
    reach = float(np.linalg.norm(vertices, axis=1).max())
    return HULL, *half_extents, 0.0, first_vertex, len(vertices), reach


def tight_frame(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The frame of a small box around points of shape (n, 3): its pose in their frame, shape (4, 4).

    Its axes are those of the points' covariance, unless the axis-aligned box is about as small.
    """
    T = np.eye(4)
    axes = np.linalg.eigh(np.cov(points.T, bias=True))[1]
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    coordinates = points @ axes
    if _surface(np.ptp(coordinates, axis=0)) < _MIN_GAIN * _surface(np.ptp(points, axis=0)):
        T[:3, :3] = axes
    else:
        coordinates = points
    T[:3, 3] = T[:3, :3] @ (0.5 * (coordinates.min(axis=0) + coordinates.max(axis=0)))
    return T


def _surface(extents: NDArray[np.float64]) -> float:
    x, y, z = extents.tolist()
    return x * y + y * z + z * x


def shape_vertices(shape: Shape | HalfSpace) -> NDArray[np.float64]:
    """The points of a hull [m], shape (n, 3); none for any other shape."""
    return shape.vertices if isinstance(shape, ConvexMesh) else NO_VERTICES
