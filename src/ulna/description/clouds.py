"""Defines point clouds and height maps: many small solids, one object of a world."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.robot_description import frozen
from ulna.description.shapes import Solid, as_points, lengths, within_reach
from ulna.errors import InputError


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points, each a ball of the same radius: the data of a depth camera or a laser scanner.

    Args:
        points: Points [m] in the frame of the object, shape (n, 3), n at least 1.
        radius: The radius of each ball [m]; with half the distance of neighbours there are no gaps.

    Raises:
        InputError: They are not points, none, not finite (a sensor's NaN does not mean free space: leave such points out), or
            farther out than a million metres.

    Example:
        >>> PointCloud([(0.5, 0, 0.2), (0.5, 0.01, 0.2)], radius=0.005)
        PointCloud(2 points, radius 0.005 m)
    """

    points: NDArray[np.float64]
    radius: float

    def __init__(self, points: ArrayLike, radius: float) -> None:
        rows = as_points("points", points)
        object.__setattr__(self, "points", frozen(rows, rows.shape))
        object.__setattr__(self, "radius", lengths("radius", (radius,), 1)[0])

    def __reduce__(self):
        return PointCloud, (self.points, self.radius)

    def __repr__(self) -> str:
        return f"PointCloud({len(self.points)} points, radius {self.radius:g} m)"


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Terrain, or a table with objects on it: square cells, each a column from ``bottom`` up to its height.

    Args:
        heights: Heights along z [m], shape (nx, ny). The grid is centred at the origin: cell i, j at x = (i - (nx - 1) / 2) cell,
            y = (j - (ny - 1) / 2) cell.
        cell: The cells' edge length [m].
        bottom: Where the columns begin [m]; the least of the heights unless given.

    Raises:
        InputError: They are not a grid of heights, not finite, or below the bottom.

    Example:
        >>> HeightMap(np.zeros((40, 30)), cell=0.02)
        HeightMap(40 x 30 cells of 0.02 m)
    """

    heights: NDArray[np.float64]
    cell: float
    bottom: float

    def __init__(self, heights: ArrayLike, cell: float, bottom: float | None = None) -> None:
        grid = within_reach("heights", heights)
        if grid.ndim != 2 or not grid.size:
            raise InputError("heights", f"shape {grid.shape}; heights of shape (nx, ny) are expected, at least one")
        lowest = grid.min() if bottom is None else within_reach("bottom", bottom)
        if lowest.ndim:
            raise InputError("bottom", f"shape {lowest.shape}; one number is expected")
        low = float(lowest)
        if (grid < low).any():
            raise InputError("bottom", f"{low:g} m is above some heights: the least is {grid.min():g} m")
        object.__setattr__(self, "heights", frozen(grid, grid.shape))
        edge = lengths("cell", (cell,), 1)[0]
        if edge == 0:
            raise InputError("cell", "0; an edge length above 0 is expected")
        object.__setattr__(self, "cell", edge)
        object.__setattr__(self, "bottom", low)

    def __reduce__(self):
        return HeightMap, (self.heights, self.cell, self.bottom)

    def __repr__(self) -> str:
        return f"HeightMap({' x '.join(map(str, self.heights.shape))} cells of {self.cell:g} m)"


Obstacle = Solid | PointCloud | HeightMap
"""What a world may hold."""
