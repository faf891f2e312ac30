"""Defines point clouds: many small balls, one object of a world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.cloud_file import points_of
from ulna.collision.cloud_points import in_box, one_per_voxel, points_of_depth
from ulna.description.arrays import as_floats
from ulna.description.file_bytes import file_bytes
from ulna.description.likely_units import check_ball, check_padding, check_place, check_points, check_voxel
from ulna.description.pose import as_one_pose
from ulna.description.shapes import Box, lengths
from ulna.errors import FileError, InputError, count_of, reason_of
from ulna.kernels.layout import LARGEST

MAX_BYTES = 1_000_000_000  # of a file
_NONE: Mapping[str, int] = MappingProxyType({})


class HasLinks(Protocol):
    """A ``Robot``."""

    def links_near(
        self, cloud: PointCloud, q: ArrayLike, *, within: float, pose: ArrayLike | None = None
    ) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """See ``Robot.links_near``."""
        ...


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points, each a ball of the same radius: the data of a depth camera or a laser scanner.

    Args:
        points: Points [m] in the frame of the object, float32 or float64, shape (n, 3), or (H, W, 3) as a camera gives them.
            Points with NaN, where a sensor measured nothing, are left out and counted; they do not mean free space. Many drivers
            write exact zeros, (0, 0, 0), there. These are left out of (H, W, 3), and of (n, 3) if there are several. An empty
            cloud, shape (0, 3), is an object that touches nothing.
        radius: The radius of each ball [m]. Half the distance between neighbors leaves no gaps.

    Attributes:
        points: The measured points, shape (n, 3), read-only; float32 if given as float32, else float64.
        radius: The radius of each ball [m].
        n_left_out: The number of given points or pixels without a measurement, which were left out.
        n_removed: The number of points that ``without`` has removed, by the name of the link or of the attached object.

    Raises:
        InputError: They are not points, none is a measurement, or one is infinite or farther out than a million meters.

    A ``UnitWarning`` is given if half of the points are farther away than 100 m.

    Example:
        >>> PointCloud([(0.5, 0, 0.2), (0.5, 0.01, 0.2)], radius=0.005)
        PointCloud(2 points, radius 0.005 m)
    """

    points: NDArray[np.floating]
    radius: float
    n_left_out: int
    n_removed: Mapping[str, int]

    def __init__(self, points: ArrayLike, radius: float) -> None:
        rows, n_left_out = _measured_points(points)
        check_points("points", rows)
        _set_attributes(self, rows, _radius(radius), n_left_out, _NONE)

    @classmethod
    def from_depth(
        cls,
        depth: ArrayLike,
        intrinsics: ArrayLike,
        T_base_camera: ArrayLike,
        *,
        radius: float,
        depth_scale: float | None = None,
        max_depth: float | None = None,
    ) -> PointCloud:
        """The points that a depth camera sees, in the base frame.

        Args:
            depth: The depth along the camera's z axis at each pixel, shape (H, W): floats [m], or integers in units of
                ``depth_scale``. Pixels with 0, NaN, infinity or 65535, and masked pixels, have no measurement. They are left out,
                and counted in ``n_left_out``.
            intrinsics: The camera matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels, shape (3, 3) or (9,), or fx, fy, cx,
                cy. The center of the first pixel is at (0, 0). The image must be free of distortion.
            T_base_camera: The pose of the camera's optical frame, shape (4, 4): z forward, x to the right, y down.
            radius: The radius of each ball [m]. Neighbors at a depth z are z / fx apart.
            depth_scale: The length of a depth of 1 [m]; 0.001 for integers and 1 for floats unless given.
            max_depth: The maximum depth that counts as a measurement [m]. Deeper pixels are left out and counted too.

        A ``UnitWarning`` is given if the camera, or half of the depths, are farther away than 100 m.

        Raises:
            InputError: The image is no depth image, or has no measurement, or none within 100 m; the intrinsics are no camera
                matrix, or their center is outside of the image; the pose is not a rigid motion.

        Example:
            >>> image = np.full((480, 640), 800, dtype=np.uint16)  # a wall at 0.8 m
            >>> image[:, :40] = 0
            >>> cloud = PointCloud.from_depth(image, (600, 600, 320, 240), np.eye(4), radius=0.002)
            >>> cloud, cloud.n_left_out
            (PointCloud(288000 points, radius 0.002 m, 19200 left out), 19200)
        """
        points, n_left_out = points_of_depth(depth, intrinsics, T_base_camera, depth_scale, max_depth)
        if not len(points):
            raise InputError("depth", f"none of {n_left_out} pixels has a depth: the camera sees nothing")
        rows, _ = _measured_points(points)
        return _set_attributes(object.__new__(cls), rows, _radius(radius), n_left_out, _NONE)

    @classmethod
    def from_file(cls, path: str | Path, *, radius: float, scale: float = 1.0, from_sensor: bool | None = None) -> PointCloud:
        """Read the points of a .npy, .xyz, .csv, .txt, .ply or .pcd file.

        Args:
            path: The file. A .npy has an array of shape (n, 3) or (H, W, 3), or records with fields x, y, z. A text file may name
                the columns x, y, z in its first line, with a unit, as in "x [mm]". Without names its first three columns are
                read.
            radius: The radius of each ball [m].
            scale: The unit of the file [m], such as 0.001.
            from_sensor: Whether the points of a .pcd are in the frame of the sensor. If so, they are moved by the pose in its
                VIEWPOINT. It is required for a file with such a pose.

        Raises:
            FileError: The file cannot be read, has no points, or has another ending.
            InputError: Its points, the radius or the scale are invalid.
            MissingExtraError: It is a .ply, and the extra ``hulls`` is not installed.
        """
        unit = lengths("scale", (scale,), 1)[0]
        try:
            content = file_bytes(path, MAX_BYTES)
        except (OSError, ValueError) as error:
            raise FileError(str(path), reason_of(error)) from None
        if len(content) > MAX_BYTES:
            raise FileError(str(path), f"has more than {MAX_BYTES // 1_000_000} MB, the maximum")
        return cls(points_of(str(path), content, unit, from_sensor=from_sensor), radius)

    def cropped(self, box: Box, pose: ArrayLike | None = None) -> PointCloud:
        """The points in a box.

        A ball whose center is outside is dropped, even if its surface reaches into the box.

        Args:
            box: The box.
            pose: T_cloud_box, shape (4, 4); the origin unless given.

        Raises:
            InputError: It is not a box, or the pose is not a rigid motion.
        """
        if not isinstance(box, Box):
            raise InputError("box", f"{type(box).__name__}; an ulna.Box is expected")
        T = as_one_pose(np.eye(4) if pose is None else pose, "pose")
        check_place("pose", T)
        return self._with(self.points[in_box(self.points, box, T)])

    def thinned(self, voxel: float) -> PointCloud:
        """Keep the point nearest to the center of each occupied voxel, with a larger radius.

        The radius grows by the maximum distance between a point and the kept point of its voxel. Each ball of this cloud is then
        inside a ball of the new cloud. A robot that is clear of the new cloud is clear of this cloud.

        Args:
            voxel: The edge of a voxel [m]. The radius grows by less than 1.74 times as much.

        Raises:
            InputError: It is not a length above 0, or less than 5e-7 of the extent of the points.
        """
        indices, thinning_error = one_per_voxel(self.points, voxel)
        check_voxel(float(voxel), self.points)
        return self._with(self.points.take(indices, axis=0), self.radius + thinning_error)

    def without(self, robot: HasLinks, q: ArrayLike, *, padding: float = 0.01, pose: ArrayLike | None = None) -> PointCloud:
        """Remove the points of the robot itself and of its attached objects; ``n_removed`` counts them.

        Args:
            robot: A ``Robot``, with collision shapes.
            q: Its joint positions when the points were measured [rad or m], shape (n_dof,).
            padding: Balls at most this far from the robot's shapes are removed [m]. It covers the errors of the camera's pose and
                of the shapes.
            pose: T_base_cloud, shape (4, 4); the origin unless given.

        Raises:
            InputError: q is not one configuration, the padding is not a length, or the pose is not a rigid motion.
            GeometryError: The robot has no collision shapes, or one of a kind that cannot be checked.
        """
        names, owner = robot.links_near(self, q, within=as_padding(padding), pose=pose)
        counts = np.bincount(owner[owner >= 0], minlength=len(names)).tolist()
        removed = dict(self.n_removed)
        for name, count in zip(names, counts, strict=True):
            if count:
                removed[name] = removed.get(name, 0) + count
        return self._with(self.points[owner < 0], n_removed=removed)

    def _with(
        self, points: NDArray[np.floating], radius: float | None = None, n_removed: Mapping[str, int] | None = None
    ) -> PointCloud:
        """A cloud of some of the points."""
        radius = self.radius if radius is None else radius
        return _make_cloud(points, radius, self.n_left_out, n_removed or self.n_removed)

    def __reduce__(self):
        return _make_cloud, (np.array(self.points), self.radius, self.n_left_out, dict(self.n_removed))

    def __repr__(self) -> str:
        left_out = f", {self.n_left_out} left out" if self.n_left_out else ""
        return f"PointCloud({count_of(len(self.points), 'point')}, radius {self.radius:g} m{left_out})"


def as_padding(padding: float) -> float:
    """The distance from a robot up to which points count as the robot's own [m]."""
    length = lengths("padding", (padding,), 1)[0]
    check_padding(length)
    return length


def _make_cloud(points: NDArray[np.floating], radius: float, n_left_out: int, n_removed: Mapping[str, int]) -> PointCloud:
    """A cloud with these attributes."""
    return _set_attributes(object.__new__(PointCloud), points, radius, n_left_out, MappingProxyType(dict(n_removed)))


def _set_attributes(
    cloud: PointCloud, points: NDArray[np.floating], radius: float, n_left_out: int, n_removed: Mapping[str, int]
) -> PointCloud:
    """Set the attributes of a new cloud, which takes ownership of the points."""
    points.setflags(write=False)
    for name, value in (("points", points), ("radius", radius), ("n_left_out", n_left_out), ("n_removed", n_removed)):
        object.__setattr__(cloud, name, value)
    return cloud


def _radius(radius: float) -> float:
    value = lengths("radius", (radius,), 1)[0]
    check_ball(value)
    return value


def _measured_points(given: ArrayLike) -> tuple[NDArray[np.floating], int]:
    """A copy of the measured points, shape (n, 3), and the number of points left out.

    NaN and a camera's exact zeros are no measurements.
    """
    is_short = type(given) is np.ndarray and given.dtype == np.float32
    array: NDArray[np.floating] = given if is_short else as_floats("points", given)  # type: ignore[assignment]
    if array.shape == (0,):
        array = array.reshape(0, 3)
    if array.ndim not in (2, 3) or array.shape[-1] != 3:
        raise InputError("points", f"shape {array.shape}; points of shape (n, 3) or (H, W, 3) are expected")
    rows = np.array(array.reshape(-1, 3), dtype=np.float32 if is_short else np.float64, order="C")
    n = len(rows)
    if n and np.isnan(rows.min()):
        rows = rows[~(np.isnan(rows[:, 0]) | np.isnan(rows[:, 1]) | np.isnan(rows[:, 2]))]
    if len(rows) and not rows.all():
        measured = rows.any(axis=1)
        if array.ndim == 3 or np.count_nonzero(measured) < len(rows) - 1:  # a list of points may contain a single (0, 0, 0)
            rows = rows[measured]
    if n and not len(rows):
        raise InputError("points", f"all {n} are NaN or (0, 0, 0): the sensor saw nothing")
    if len(rows) and not (rows.min() >= -LARGEST and rows.max() <= LARGEST):
        raise InputError("points", f"finite numbers of at most {LARGEST:g} m, or NaN, are expected")
    return rows, n - len(rows)
