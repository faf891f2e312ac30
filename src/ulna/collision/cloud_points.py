"""Computes the points of a cloud: those that a depth camera sees, those in a box, one in each voxel."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_floats
from ulna.description.pose import as_one_pose
from ulna.description.shapes import Box
from ulna.drivers import thinning
from ulna.engine.threads import LEAST_POSES, in_parts
from ulna.errors import InputError
from ulna.kernels.layout import CONTACT

Points = NDArray[np.floating]
MILLIMETRE = 0.001  # a unit of whole numbers, unless given
_MOST_VOXELS = 1 << 21  # along an axis (``drivers.thinning``)


def points_of_depth(
    depth: ArrayLike, intrinsics: ArrayLike, T_base_camera: ArrayLike, depth_scale: float | None
) -> tuple[NDArray[np.float64], int]:
    """The points that a camera sees [m], shape (n, 3), and how many pixels saw nothing. Arguments as ``PointCloud.from_depth``.

    Raises:
        InputError: An argument is not what it should be.
    """
    z = as_depths(depth, depth_scale)
    K, T = camera_matrix(intrinsics, z.shape), as_one_pose(T_base_camera, "T_base_camera")
    seen = z > 0
    height, width = z.shape
    across, down = (np.arange(width) - K[0, 2]) / K[0, 0], (np.arange(height) - K[1, 2]) / K[1, 1]
    z, points = z[seen], np.empty((int(np.count_nonzero(seen)), 3))
    for axis in range(3):
        rays = (T[axis, 0] * across)[None, :] + (T[axis, 1] * down + T[axis, 2])[:, None]
        points[:, axis] = rays[seen] * z + T[axis, 3]
    return points, seen.size - len(points)


def as_depths(depth: ArrayLike, depth_scale: float | None) -> NDArray[np.float64]:
    """The depths of an image [m], shape (H, W); 0 where nothing was measured.

    Raises:
        InputError: It is not an image of depths.
    """
    image = np.asarray(depth)
    if image.ndim != 2 or image.dtype.kind not in "uif":
        raise InputError("depth", f"shape {image.shape} of {image.dtype}; numbers of shape (H, W) are expected")
    z = image * _scale(depth_scale, image)  # float64
    if (z < 0).any():
        raise InputError("depth", f"{z[z < 0].min():g} m; a depth is not below 0")
    return np.where((z > 0) & (z < np.inf), z, 0.0)


def _scale(depth_scale: float | None, image: NDArray) -> float:
    if depth_scale is None:
        return 1.0 if image.dtype.kind == "f" else MILLIMETRE
    scale = as_floats("depth_scale", depth_scale)
    if scale.shape or not 0 < scale < np.inf:
        raise InputError("depth_scale", f"{depth_scale!r}; one number above 0 [m] is expected")
    return float(scale)


def camera_matrix(intrinsics: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """The camera matrix, shape (3, 3), of the image's size."""
    K = as_floats("intrinsics", intrinsics)
    if K.shape == (4,):
        K = np.array([[K[0], 0, K[2]], [0, K[1], K[3]], [0, 0, 1]])
    elif K.shape == (9,):
        K = K.reshape(3, 3)
    if K.shape != (3, 3) or not np.isfinite(K).all():
        raise InputError("intrinsics", f"shape {K.shape}; a finite camera matrix, shape (3, 3), or fx, fy, cx, cy is expected")
    if K[0, 1] or K[1, 0] or K[2].tolist() != [0, 0, 1]:
        raise InputError("intrinsics", "not of the form [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        raise InputError("intrinsics", f"fx = {K[0, 0]:g}, fy = {K[1, 1]:g}; focal lengths above 0, in pixels, are expected")
    for name, centre, size in (("cx", K[0, 2], shape[1]), ("cy", K[1, 2], shape[0])):
        if not -0.5 <= centre <= size - 0.5:
            what = f"{name} = {centre:g} is outside of the image of {shape[1]} x {shape[0]} pixels"
            raise InputError("intrinsics", f"{what}: are they those of another resolution?")
    return K


def in_box(points: Points, box: Box, T: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points are in a box at a pose T_cloud_box, shape (n,)."""
    inside = np.ones(len(points), dtype=bool)
    for axis, half in enumerate(box.half_extents):
        inside &= np.abs(points @ T[:3, axis] - T[:3, 3] @ T[:3, axis]) <= half
    return inside


def one_per_voxel(points: Points, voxel: float) -> tuple[NDArray[np.bool_], float]:
    """Which points to keep, one in each voxel that has any; how far any is at most from the one kept in its voxel [m]."""
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
    found, table = np.array([*low, 0.0]), _table_of(points, float(edge), low)

    def compare(rows: slice) -> bool:
        thinning.compare_with_kept(points, float(edge), found, *table, np.array([rows.start, rows.stop]), kept)
        return True

    in_parts(compare, len(points), LEAST_POSES, threads=1)
    return kept, float(found[3]) * (1.0 + 4.0 * CONTACT)


def _table_of(points: Points, edge: float, low: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The hash table of the voxels that have points, and of the point nearest to the middle of each (``drivers.thinning``)."""

    def empty(size: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return np.full(size, thinning.FREE_SLOT), np.empty(size, np.int64)

    table, progress = empty(thinning.FIRST_SIZE), np.zeros(3, np.int64)

    def put(rows: slice) -> bool:
        nonlocal table
        progress[1] = rows.stop
        thinning.fill_slots(points, edge, low, *table, progress)
        while progress[0] < rows.stop:
            larger = empty(4 * len(table[0]))
            thinning.move_slots(*table, *larger)
            table = larger
            thinning.fill_slots(points, edge, low, *table, progress)
        return True

    in_parts(put, len(points), LEAST_POSES, threads=1)
    return table
