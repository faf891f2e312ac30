"""Defines height maps and voxel grids: many boxes in a lattice, one object of a world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.cloud_points import as_depths, camera_matrix, camera_pose
from ulna.collision.clouds import HasLinks, PointCloud, as_padding
from ulna.description.arrays import as_cells
from ulna.description.likely_units import check_cell, check_heights, check_place
from ulna.description.pose import as_one_pose
from ulna.description.robot_description import frozen
from ulna.description.shapes import Box, Solid, lengths, within_reach
from ulna.errors import InputError

Array = NDArray[np.float64]
_MAX_CELLS = 1 << 24  # in a grid: 16 million
_LATTICE_TOLERANCE = 0.01  # cells: tolerance on a center's distance from the lattice of the others
_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Terrain, or a table with objects on it: square cells, each a column from ``bottom`` up to its height.

    Args:
        heights: Heights along z [m], shape (nx, ny). The grid is centered at the origin: cell i, j is at x = (i - (nx - 1) / 2)
            cell, y = (j - (ny - 1) / 2) cell.
        cell: The cells' edge length [m].
        bottom: The z of the columns' lower ends [m]; the minimum height unless given.

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
        low, edge = float(lowest), _as_edge(cell)
        if (grid < low).any():
            raise InputError("bottom", f"{low:g} m is above some heights: the least is {grid.min():g} m")
        check_heights(grid, low, edge)
        object.__setattr__(self, "heights", frozen(grid, grid.shape))
        object.__setattr__(self, "cell", edge)
        object.__setattr__(self, "bottom", low)

    @property
    def boxes(self) -> tuple[Array, Array]:
        """The centers of the boxes in the frame of the object [m], and their half extents, shape (n, 3) each."""
        nx, ny = self.heights.shape
        x, y = ((np.arange(n) - (n - 1) / 2) * self.cell for n in (nx, ny))
        half = np.empty((nx * ny, 3))
        half[:, :2], half[:, 2] = self.cell / 2, (self.heights.ravel() - self.bottom) / 2
        return np.column_stack([np.repeat(x, ny), np.tile(y, nx), self.bottom + half[:, 2]]), half

    def __reduce__(self):
        return HeightMap, (self.heights, self.cell, self.bottom)

    def __repr__(self) -> str:
        return f"HeightMap({' x '.join(map(str, self.heights.shape))} cells of {self.cell:g} m)"


@dataclass(frozen=True, eq=False)
class VoxelGrid:
    """Cubes in a lattice, as in OctoMap and nvblox, or the space that a camera does not see.

    Args:
        occupied: The occupied cells as a mask, shape (nx, ny, nz), bools or 0 and 1. Mark cells unknown to the sensor as
            occupied: they are not free. Cells of a masked array that are masked count as occupied.
        cell: The cells' edge length [m].
        corner: The corner of the grid with the minimum x, y and z, in the frame of the object [m], shape (3,). The grid is
            centered at the origin unless given. Cell i, j, k begins at ``corner + (i, j, k) cell``.

    Raises:
        InputError: It is not a grid of cells, or has more than 16 million; or a length is invalid.

    Example:
        >>> VoxelGrid(np.ones((4, 4, 2)), cell=0.05)
        VoxelGrid(4 x 4 x 2 cells of 0.05 m, 32 occupied)
    """

    occupied: NDArray[np.bool_]
    cell: float
    corner: Array

    def __init__(self, occupied: ArrayLike, cell: float, corner: ArrayLike | None = None) -> None:
        given = as_cells("occupied", occupied, 1)
        grid = given.astype(bool) if given.dtype.kind in "buif" else given
        if grid.ndim != 3 or grid.dtype != np.bool_ or (grid != given).any():
            raise InputError(
                "occupied", f"shape {given.shape} of {given.dtype}; bools, or 0 and 1, of shape (nx, ny, nz) are expected"
            )
        if grid.size > _MAX_CELLS:
            raise InputError("occupied", f"{grid.size} cells; at most {_MAX_CELLS} are expected")
        edge = _as_edge(cell)
        at = within_reach("corner", -0.5 * edge * np.array(grid.shape) if corner is None else corner)
        if at.shape != (3,):
            raise InputError("corner", f"shape {at.shape}; a point of shape (3,) is expected")
        grid.setflags(write=False)
        for name, value in (("occupied", grid), ("cell", edge), ("corner", frozen(at, (3,)))):
            object.__setattr__(self, name, value)

    @classmethod
    def of_centers(cls, centers: ArrayLike, cell: float) -> VoxelGrid:
        """The grid whose occupied cells have these centers, for example the leaves of an OctoMap at one depth.

        Args:
            centers: The centers [m], shape (n, 3), n >= 1. Their distances along each axis are multiples of ``cell``.
            cell: The cells' edge length [m].

        Raises:
            InputError: They are no centers of cells of this length, or the grid would have more than 16 million.

        Example:
            >>> VoxelGrid.of_centers([(0.525, 0, 0.1), (0.575, 0, 0.1)], cell=0.05)
            VoxelGrid(2 x 1 x 1 cells of 0.05 m, 2 occupied)
        """
        points, edge = within_reach("centers", centers), _as_edge(cell)
        if points.ndim != 2 or points.shape[1:] != (3,) or not len(points):
            raise InputError("centers", f"shape {points.shape}; points of shape (n, 3) are expected, at least one")
        low = points.min(axis=0)
        steps = (points - low) / edge
        index = np.rint(steps)
        if (deviation := float(np.abs(steps - index).max())) > _LATTICE_TOLERANCE:
            raise InputError(
                "centers", f"one is off the lattice of the others by {deviation:.2g} of a cell: is {edge:g} m their edge length?"
            )
        shape = index.max(axis=0) + 1
        if shape.prod() > _MAX_CELLS:
            raise InputError("centers", f"{shape.prod():.3g} cells from the first to the last; at most {_MAX_CELLS} are expected")
        grid = np.zeros(shape.astype(int), dtype=bool)
        grid[tuple(index.astype(int).T)] = True
        return cls(grid, edge, low - edge / 2)

    @classmethod
    def unseen(
        cls,
        depth: ArrayLike,
        intrinsics: ArrayLike,
        T_base_camera: ArrayLike,
        box: Box,
        cell: float,
        *,
        pose: ArrayLike | None = None,
        depth_scale: float | None = None,
        max_depth: float | None = None,
    ) -> VoxelGrid:
        """Cells of a box that a depth camera does not see to be empty: occluded or outside its image.

        A cell is empty if the camera sees past all of it. All of its corners are then in front of the camera, and all pixels that
        it may cover have a depth beyond it. So the visible surfaces are occupied too. Between pixels, nothing is assumed to be
        nearer than at the pixels around. ``without`` removes the robot, which hides the space behind it.

        Args:
            depth: As in ``PointCloud.from_depth``. Pixels of 0, NaN, infinity or 65535 see nothing.
            intrinsics: As in ``PointCloud.from_depth``.
            T_base_camera: As in ``PointCloud.from_depth``.
            box: The part of the workspace to fill.
            cell: The cells' edge length [m]. The grid is as large as the box, rounded up to whole cells.
            pose: T_base_box, shape (4, 4), for ``World.add`` too; the base frame unless given.
            depth_scale: As in ``PointCloud.from_depth``.
            max_depth: As in ``PointCloud.from_depth``. A pixel with a depth beyond it makes no cell empty.

        Raises:
            InputError: An argument has a wrong form or a value out of range, or the grid would have more than 16 million cells.

        Example:
            >>> from ulna.description.pose import pose
            >>> image = np.full((480, 640), 800, dtype=np.uint16)  # a wall at 0.8 m
            >>> VoxelGrid.unseen(image, (600, 600, 320, 240), np.eye(4), Box((0.2, 0.2, 0.4)), 0.1, pose=pose((0, 0, 0.8)))
            VoxelGrid(2 x 2 x 4 cells of 0.1 m, 12 occupied)
        """
        if not isinstance(box, Box):
            raise InputError("box", f"{type(box).__name__}; an ulna.Box is expected")
        edge, extents = _as_edge(cell), 2 * np.array(box.half_extents)
        shape = np.maximum(np.ceil(extents / edge * (1 - 1e-12)), 1)
        if shape.prod() > _MAX_CELLS:
            raise InputError("cell", f"{edge:g} m makes {shape.prod():.3g} cells; at most {_MAX_CELLS} are expected")
        z = as_depths(depth, depth_scale, max_depth)
        K, T_camera = camera_matrix(intrinsics, z.shape), camera_pose(T_base_camera)
        T_box = as_one_pose(np.eye(4) if pose is None else pose, "pose")
        check_place("pose", T_box)
        R = T_camera[:3, :3].T @ T_box[:3, :3]
        origin = T_camera[:3, :3].T @ (T_box[:3, 3] - T_camera[:3, 3])
        index = np.indices(tuple(shape.astype(int))).reshape(3, -1).T
        corner = -0.5 * edge * shape
        free = np.zeros(len(index), dtype=bool)
        pyramid = _MinDepthPyramid(z)
        for rows in np.array_split(np.arange(len(index)), max(1, len(index) >> 16)):
            corners = ((index[rows, None] + _CORNERS) * edge + corner) @ R.T + origin
            free[rows] = pyramid.is_beyond(corners, K)
        return cls(~free.reshape(shape.astype(int)), edge)

    def without(self, robot: HasLinks, q: ArrayLike, *, padding: float = 0.01, pose: ArrayLike | None = None) -> VoxelGrid:
        """Remove the cells of the robot itself; arguments and errors as in ``PointCloud.without``.

        A cell belongs to the robot if the ball around the cell is at most the padding away from a shape of the robot.
        """
        index = np.argwhere(self.occupied)
        balls = PointCloud(self.corner + (index + 0.5) * self.cell, self.cell * math.sqrt(3) / 2)
        _, owner = robot.links_near(balls, q, within=as_padding(padding), pose=pose)
        occupied = np.array(self.occupied)
        occupied[tuple(index[owner >= 0].T)] = False
        return VoxelGrid(occupied, self.cell, self.corner)

    @property
    def boxes(self) -> tuple[Array, Array]:
        """The centers [m] and half extents of boxes that fill the occupied cells, shape (n, 3) each.

        Each box is a run of occupied cells along z.
        """
        padded = np.pad(self.occupied, ((0, 0), (0, 0), (1, 1))).astype(np.int8)
        changes = np.diff(padded, axis=2)
        begins, ends = np.argwhere(changes == 1), np.argwhere(changes == -1)
        half = np.full((len(begins), 3), 0.5 * self.cell)
        half[:, 2] *= ends[:, 2] - begins[:, 2]
        return self.corner + begins * self.cell + half, half

    def __reduce__(self):
        return VoxelGrid, (self.occupied, self.cell, self.corner)

    def __repr__(self) -> str:
        cells = " x ".join(map(str, self.occupied.shape))
        return f"VoxelGrid({cells} cells of {self.cell:g} m, {np.count_nonzero(self.occupied)} occupied)"


class _MinDepthPyramid:
    """A pyramid of minimum depths: level k, entry i, j covers the 2^k x 2^k pixels from i, j on."""

    def __init__(self, depth: Array) -> None:
        self.levels, step = [depth], 1
        while 2 * step <= min(depth.shape):
            last = self.levels[-1]
            rows = np.minimum(last[:-step], last[step:])
            self.levels.append(np.minimum(rows[:, :-step], rows[:, step:]))
            step *= 2

    def is_beyond(self, corners: Array, K: Array) -> NDArray[np.bool_]:
        """Whether the image is deeper than each cell at all pixels that the cell may cover, shape (n,).

        corners: The corners of the cells in the camera's frame, shape (n, 8, 3).
        """
        z = corners[..., 2]
        depths = np.where(z > 0, z, 1.0)
        u, v = (corners[..., axis] / depths * K[axis, axis] + K[axis, 2] for axis in (0, 1))
        first = np.floor(np.stack([v.min(axis=1), u.min(axis=1)], axis=1))  # row and column
        last = np.ceil(np.stack([v.max(axis=1), u.max(axis=1)], axis=1))
        size = np.array(self.levels[0].shape)
        level = np.frexp((last - first).max(axis=1) + 1)[1] - 1  # of the largest squares not longer than the longer side
        inside = (z.min(axis=1) > 0) & (first >= 0).all(axis=1) & (last < size).all(axis=1) & (level < len(self.levels))
        deeper = np.zeros(len(corners), dtype=bool)
        for k in np.unique(level[inside]).tolist():  # four squares at the corners cover the rectangle
            cells = np.flatnonzero(inside & (level == k))
            begin = np.minimum(first[cells], size - 2**k).astype(int)
            end = np.maximum(last[cells] - 2**k + 1, 0).astype(int)
            min_depth = np.min(
                [self.levels[k][rows[:, 0], columns[:, 1]] for rows in (begin, end) for columns in (begin, end)], axis=0
            )
            deeper[cells] = min_depth > z[cells].max(axis=1)
        return deeper


def _as_edge(cell: float) -> float:
    edge = lengths("cell", (cell,), 1)[0]
    if edge == 0:
        raise InputError("cell", "0; an edge length above 0 is expected")
    check_cell(edge)
    return edge


Obstacle = Solid | PointCloud | HeightMap | VoxelGrid
"""What a world may hold."""
