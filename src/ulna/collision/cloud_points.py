"""Computes the points of a cloud: from a depth image, inside a box, or one for each voxel."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.entries import thinning
from ulna.description.arrays import as_cells, as_floats, positive
from ulna.description.likely_units import check_depths, check_place
from ulna.description.pose import as_one_pose
from ulna.description.shapes import Box
from ulna.engine.threads import MIN_POSES, in_slices
from ulna.errors import InputError
from ulna.kernels.layout import CONTACT

Points = NDArray[np.floating]
MILLIMETER = 0.001  # a unit of whole numbers, unless given
_MAX_VOXELS = 1 << 21  # along an axis (``collision.entries.thinning``)
_BLOCK = 64
_SATURATED, _SATURATED_TOLERANCE = 65535, 1e-5  # and [m] by which it may be rounded as a float32


def points_of_depth(
    depth: ArrayLike,
    intrinsics: ArrayLike,
    T_base_camera: ArrayLike,
    depth_scale: float | None,
    max_depth: float | None,
) -> tuple[NDArray[np.float64], int]:
    """The points that a camera sees [m], shape (n, 3), and the number of pixels without a measurement.

    Arguments as in ``PointCloud.from_depth``.

    Raises:
        InputError: An argument has a wrong type, shape or value.
    """
    z = as_depths(depth, depth_scale, max_depth)
    K, T = camera_matrix(intrinsics, z.shape), camera_pose(T_base_camera)
    measured = z > 0
    height, width = z.shape
    u_slopes, v_slopes = (np.arange(width) - K[0, 2]) / K[0, 0], (np.arange(height) - K[1, 2]) / K[1, 1]
    z, points = z[measured], np.empty((int(np.count_nonzero(measured)), 3))
    for axis in range(3):
        rays = (T[axis, 0] * u_slopes)[None, :] + (T[axis, 1] * v_slopes + T[axis, 2])[:, None]
        points[:, axis] = rays[measured] * z + T[axis, 3]
    return points, measured.size - len(points)


def camera_pose(T_base_camera: ArrayLike) -> NDArray[np.float64]:
    """A camera's pose, validated, shape (4, 4)."""
    T = as_one_pose(T_base_camera, "T_base_camera")
    check_place("T_base_camera", T)
    return T


def as_depths(depth: ArrayLike, depth_scale: float | None, max_depth: float | None = None) -> NDArray[np.float64]:
    """The depths of an image [m], shape (H, W). Pixels without a measurement, or beyond ``max_depth``, are 0.

    Raises:
        InputError: It is not a depth image, its values are impossible for a camera, or ``max_depth`` is not a length.
    """
    max_z = np.inf if max_depth is None else positive("max_depth", max_depth, "a depth [m] above 0")
    image = as_cells("depth", depth, 0)
    if image.ndim != 2 or image.dtype.kind not in "uif":
        raise InputError("depth", f"shape {image.shape} of {image.dtype}; numbers of shape (H, W) are expected")
    raw = image.astype(np.float64)
    z = raw * _scale(depth_scale, image)
    if (z < 0).any():
        raise InputError("depth", f"{z[z < 0].min():g} m; a depth is not below 0")
    z = np.where((z > 0) & (z < np.inf) & ~_is_saturated(image.dtype, raw, z), z, 0.0)
    check_depths(z)
    return z if max_depth is None else np.where(z <= max_z, z, 0.0)


def _is_saturated(kind: np.dtype, image: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mask of the pixels with the largest 16-bit number, which cameras write for a missing measurement.

    The number counts as itself, as a float, or in meters. For other unsigned integers it is the largest of their type.
    """
    saturated = (image == _SATURATED) | (np.abs(z - _SATURATED * MILLIMETER) < _SATURATED_TOLERANCE)
    return saturated | (image == float(np.iinfo(kind).max)) if kind.kind == "u" else saturated


def _scale(depth_scale: float | None, image: NDArray) -> float:
    if depth_scale is None:
        return 1.0 if image.dtype.kind == "f" else MILLIMETER
    scale = as_floats("depth_scale", depth_scale)
    if scale.shape or not 0 < scale < np.inf:
        raise InputError("depth_scale", f"{depth_scale!r}; one number above 0 [m] is expected")
    return float(scale)


def camera_matrix(intrinsics: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """The camera matrix for an image of this shape, shape (3, 3)."""
    given = as_floats("intrinsics", intrinsics)
    if given.shape == (4,):
        given = np.array([[given[0], 0, given[2]], [0, given[1], given[3]], [0, 0, 1]])
    K = given.reshape(3, 3) if given.shape == (9,) else given
    if K.shape != (3, 3) or not np.isfinite(K).all():
        raise InputError("intrinsics", f"shape {K.shape}; a finite camera matrix, shape (3, 3), or fx, fy, cx, cy is expected")
    if K[0, 1] or K[1, 0] or K[2].tolist() != [0, 0, 1]:
        raise InputError("intrinsics", "not of the form [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        raise InputError("intrinsics", f"fx = {K[0, 0]:g}, fy = {K[1, 1]:g}; focal lengths above 0, in pixels, are expected")
    for name, center, size in (("cx", K[0, 2], shape[1]), ("cy", K[1, 2], shape[0])):
        if not -0.5 <= center <= size - 0.5:
            what = f"{name} = {center:g} is outside of the image of {shape[1]} x {shape[0]} pixels"
            raise InputError("intrinsics", f"{what}: are they those of another resolution?")
    return K


def in_box(points: Points, box: Box, T: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Mask of the points in a box at a pose T_cloud_box, shape (n,)."""
    inside = np.ones(len(points), dtype=bool)
    for axis, half in enumerate(box.half_extents):
        inside &= np.abs(points @ T[:3, axis] - T[:3, 3] @ T[:3, axis]) <= half
    return inside


def one_per_voxel(points: Points, voxel: float) -> tuple[NDArray[np.int64], float]:
    """The indices of the points to keep, one for each occupied voxel, and the thinning error [m].

    The error is the maximum distance between a point and the kept point of its voxel.
    """
    edge = as_floats("voxel", voxel)
    if edge.shape or not 0 < edge < np.inf:
        raise InputError("voxel", f"{voxel!r}; a length above 0 [m] is expected")
    if not len(points):
        return np.empty(0, np.int64), 0.0
    low, high = _bounds(points)
    widest = float((high - low).max())
    if widest >= (_MAX_VOXELS - 1) * float(edge):
        raise InputError("voxel", f"{edge:g} m is too small for points {widest:g} m apart: crop the cloud first")
    (indices, voxel_of_point), error = _voxels_of(points, float(edge), low), np.zeros(1)

    def compare(rows: slice) -> bool:
        thinning.measure_thinning(points, indices, voxel_of_point, np.array([rows.start, rows.stop]), error)
        return True

    in_slices(compare, slice(0, len(points)), MIN_POSES)
    return indices, float(error[0]) * (1.0 + 4.0 * CONTACT)


def _bounds(points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The minimum and maximum x, y, z."""
    n_in_blocks = len(points) // _BLOCK * _BLOCK
    if n_in_blocks:  # a minimum over rows of three numbers would take many times longer
        blocks = points[:n_in_blocks].reshape(-1, 3 * _BLOCK)
        points = np.concatenate([blocks.min(axis=0).reshape(-1, 3), blocks.max(axis=0).reshape(-1, 3), points[n_in_blocks:]])
    return points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)


def _voxels_of(points: Points, edge: float, low: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The point nearest to the center of each occupied voxel, and the voxel of each point (``entries.thinning``)."""
    n, slots, progress = len(points), np.zeros(thinning.FIRST_SIZE, np.int64), np.zeros(3, np.int64)
    voxels = thinning.Voxels(np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n), np.empty(n, np.int64))

    def insert(rows: slice) -> bool:
        nonlocal slots
        progress[1] = rows.stop
        while True:
            thinning.fill_slots(points, edge, low, slots, voxels, progress)
            if progress[0] == rows.stop:
                return True
            slots = np.zeros(4 * len(slots), np.int64)
            thinning.move_slots(voxels.numbers[: progress[2]], slots)

    in_slices(insert, slice(0, n), MIN_POSES)
    return voxels.nearest[: progress[2]], voxels.voxel_of_point
