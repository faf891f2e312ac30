"""Lists the solids of a world's object: one, or many for a point cloud."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ulna.collision.clouds import HeightMap, Obstacle, PointCloud
from ulna.collision.rounded_shapes import NO_VERTICES, shape_columns, shape_vertices
from ulna.description.shapes import Sphere
from ulna.kernels.layout import BODY_WIDTH, BOX, HALF_EXTENTS, RADIUS, REACH, SHAPE

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solids:
    """The solids of one object.

    Attributes:
        places: The centre of each in the frame of the object [m], shape (n, 3). None is turned.
        columns: What the kernels read of its shape (``rounded_shapes.shape_columns``), shape (n, 8).
        vertices: Those of a hull, shape (m, 3).
    """

    places: NDArray[np.floating]
    columns: Array
    vertices: Array


def expand(shape: Obstacle) -> Solids:
    """The solids of an object."""
    match shape:
        case PointCloud(points=points, radius=radius):
            return Solids(points, np.tile(shape_columns(Sphere(radius)), (len(points), 1)), NO_VERTICES)
        case HeightMap():
            return _columns_of_cells(shape)
    return Solids(np.zeros((1, 3)), np.array([shape_columns(shape)]), shape_vertices(shape))


def _columns_of_cells(terrain: HeightMap) -> Solids:
    """A box for each cell."""
    nx, ny = terrain.heights.shape
    x, y = ((np.arange(n) - (n - 1) / 2) * terrain.cell for n in (nx, ny))
    half = np.empty((nx * ny, 3))
    half[:, :2], half[:, 2] = terrain.cell / 2, (terrain.heights.ravel() - terrain.bottom) / 2
    places = np.column_stack([np.repeat(x, ny), np.tile(y, nx), terrain.bottom + half[:, 2]])
    columns = np.zeros((nx * ny, BODY_WIDTH - SHAPE))
    columns[:, 0], columns[:, REACH - SHAPE] = BOX, np.linalg.norm(half, axis=1)
    columns[:, HALF_EXTENTS - SHAPE : RADIUS - SHAPE] = half
    return Solids(places, columns, NO_VERTICES)
