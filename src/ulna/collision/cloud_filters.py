"""Filters the points of a cloud: crops them to a box, and keeps one in each voxel."""

import numpy as np
from numpy.typing import NDArray

from ulna.description.arrays import as_floats
from ulna.description.shapes import Box
from ulna.drivers import thinning
from ulna.errors import InputError
from ulna.kernels.layout import CONTACT

Points = NDArray[np.floating]
_MOST_VOXELS = 1 << 21  # along an axis (``drivers.thinning``)


def in_box(points: Points, box: Box, T: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points are in a box at a pose T_cloud_box, shape (n,)."""
    inside = np.ones(len(points), dtype=bool)
    for axis, half in enumerate(box.half_extents):
        inside &= np.abs(points @ T[:3, axis] - T[:3, 3] @ T[:3, axis]) <= half
    return inside


def one_per_voxel(points: Points, voxel: float) -> tuple[NDArray[np.bool_], float]:
    """Which points to keep, one in each voxel that has any; how far any is at most from the one kept in its voxel [m].

    Raises:
        InputError: The voxel is not a length above 0, or too small for the extent of the points.
    """
    edge = as_floats("voxel", voxel)
    if edge.shape or not 0 < edge < np.inf:
        raise InputError("voxel", f"{voxel!r}; a length above 0 [m] is expected")
    kept = np.ones(len(points), dtype=bool)
    if not len(points):
        return kept, 0.0
    columns = [points[:, axis] for axis in range(3)]  # a minimum along the first axis would take several times as long
    low = np.array([column.min() for column in columns], dtype=np.float64)
    widest = max(float(column.max()) - low[axis] for axis, column in enumerate(columns))
    if widest >= (_MOST_VOXELS - 1) * float(edge):
        raise InputError("voxel", f"{edge:g} m is too small for points {widest:g} m apart: crop the cloud first")
    found = np.array([*low, 0.0])
    thinning.thin(points, float(edge), found, kept)
    return kept, float(found[3]) * (1.0 + 4.0 * CONTACT)
