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
        """As ``Robot.links_near``."""
        ...


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points, each a ball of the same radius: the data of a depth camera or a laser scanner.

    Args:
        points: Points [m] in the frame of the object, shape (n, 3), or (H, W, 3) as a camera gives them, as float32 or float64. A
            point with NaN, where a sensor saw nothing, is left out and counted: it does not mean free space. Nor do exact
            zeros, (0, 0, 0), which many drivers write there: they are left out of (H, W, 3), and of (n, 3) where there are
            several. None at all, shape (0, 3), is an object that touches nothing.
        radius: The radius of each ball [m]; with half the distance of neighbours there are no gaps.

    Attributes:
        points: Those that were measured, shape (n, 3), read-only, float32 if they were given so, else float64.
        radius: The radius of each ball [m].
        n_left_out: How many were left out, of the points or pixels given, since they are no measurement.
        n_removed: How many ``without`` has removed, by the name of the link or of the attached object.

    Raises:
        InputError: They are not points, none is a measurement, or one is infinite or farther out than a million metres.

    Half of the points beyond 100 m give a ``UnitWarning``.

    Example:
        >>> PointCloud([(0.5, 0, 0.2), (0.5, 0.01, 0.2)], radius=0.005)
        PointCloud(2 points, radius 0.005 m)
    """

    points: NDArray[np.floating]
    radius: float
    n_left_out: int
    n_removed: Mapping[str, int]

    def __init__(self, points: ArrayLike, radius: float) -> None:
        rows, n_left_out = _seen(points)
        check_points("points", rows)
        _fill(self, rows, _radius(radius), n_left_out, _NONE)

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
            depth: The depth along the camera's z axis at each pixel, shape (H, W): floats [m], or whole numbers of
                ``depth_scale``. 0, NaN, infinity and 65535 are no measurement, nor is what is masked: such pixels are left
                out, and counted as ``n_left_out``.
            intrinsics: The camera matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels, shape (3, 3) or (9,), or fx, fy, cx,
                cy. The middle of the first pixel is at (0, 0). The image is not distorted.
            T_base_camera: The pose of the camera's optical frame, shape (4, 4): z forward, x to the right, y down.
            radius: The radius of each ball [m]. Neighbours at a depth z are z / fx apart.
            depth_scale: What a depth of 1 is [m]; 0.001 for whole numbers and 1 for floats unless given.
            max_depth: The greatest depth that is a measurement [m]: what is beyond is left out and counted too.

        Half of the depths, or the camera, beyond 100 m give a ``UnitWarning``.

        Raises:
            InputError: The image is not one of depths, sees nothing, or nothing within 100 m; the intrinsics are no camera
                matrix, or their centre is outside of the image; the pose is not a rigid motion.

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
        rows, _ = _seen(points)
        return _fill(object.__new__(cls), rows, _radius(radius), n_left_out, _NONE)

    @classmethod
    def from_file(cls, path: str | Path, *, radius: float, scale: float = 1.0, from_sensor: bool | None = None) -> PointCloud:
        """The points of a .npy, .xyz, .csv, .txt, .ply or .pcd file.

        Args:
            path: The file. A .npy has an array of shape (n, 3) or (H, W, 3), or of records with fields x, y, z. Of lines of text
                those columns count that are named x, y, z in the first line, in the unit that it may state, as in "x [mm]";
                without names the first three.
            radius: The radius of each ball [m].
            scale: The unit of the file [m], such as 0.001.
            from_sensor: Whether the points of a .pcd are in the frame of the sensor: they are then moved by the pose that its
                VIEWPOINT states. A file that states one is refused unless this is given.

        Raises:
            FileError: It cannot be read, has no points, or ends otherwise.
            InputError: Its points, the radius or the scale cannot be taken.
            MissingExtraError: It is a .ply, and the extra ``hulls`` is not installed.
        """
        unit = lengths("scale", (scale,), 1)[0]
        try:
            content = file_bytes(path, MAX_BYTES)
        except (OSError, ValueError) as error:
            raise FileError(str(path), reason_of(error)) from None
        if len(content) > MAX_BYTES:
            raise FileError(str(path), f"has more than {MAX_BYTES // 1_000_000} MB, the most that is read")
        return cls(points_of(str(path), content, unit, from_sensor=from_sensor), radius)

    def cropped(self, box: Box, pose: ArrayLike | None = None) -> PointCloud:
        """The points in a box; a ball outside of it whose surface reaches in is dropped too.

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
        """One point for each voxel that has any, the one nearest to its middle, as a larger ball.

        The radius grows by how far any point is at most from the one that is kept in its voxel. So each ball of this cloud is
        within one of the new cloud: what is free beside the new one is free beside this one.

        Args:
            voxel: The edge of a voxel [m]. The radius grows by less than 1.74 times as much.

        Raises:
            InputError: It is not a length above 0, or less than 5e-7 of the extent of the points.
        """
        kept, farthest = one_per_voxel(self.points, voxel)
        check_voxel(float(voxel), self.points)
        return self._with(self.points.take(kept, axis=0), self.radius + farthest)

    def without(self, robot: HasLinks, q: ArrayLike, *, padding: float = 0.01, pose: ArrayLike | None = None) -> PointCloud:
        """The points that are not of the robot itself, or of what is attached to it; ``n_removed`` counts the others.

        Args:
            robot: A ``Robot``, with collision shapes.
            q: Its joint positions when the points were measured [rad or m], shape (n_dof,).
            padding: Balls no farther than this from the robot's shapes are removed [m]: the error of the camera's pose, and of
                the shapes.
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
        return _remade(points, radius, self.n_left_out, n_removed or self.n_removed)

    def __reduce__(self):
        return _remade, (np.array(self.points), self.radius, self.n_left_out, dict(self.n_removed))

    def __repr__(self) -> str:
        left_out = f", {self.n_left_out} left out" if self.n_left_out else ""
        return f"PointCloud({count_of(len(self.points), 'point')}, radius {self.radius:g} m{left_out})"


def as_padding(padding: float) -> float:
    """The distance from a robot up to which points count as its own [m]."""
    length = lengths("padding", (padding,), 1)[0]
    check_padding(length)
    return length


def _remade(points: NDArray[np.floating], radius: float, n_left_out: int, n_removed: Mapping[str, int]) -> PointCloud:
    """A cloud of these attributes."""
    return _fill(object.__new__(PointCloud), points, radius, n_left_out, MappingProxyType(dict(n_removed)))


def _fill(
    cloud: PointCloud, points: NDArray[np.floating], radius: float, n_left_out: int, n_removed: Mapping[str, int]
) -> PointCloud:
    """Set the attributes of a new cloud; the points are its own."""
    points.setflags(write=False)
    for name, value in (("points", points), ("radius", radius), ("n_left_out", n_left_out), ("n_removed", n_removed)):
        object.__setattr__(cloud, name, value)
    return cloud


def _radius(radius: float) -> float:
    value = lengths("radius", (radius,), 1)[0]
    check_ball(value)
    return value


def _seen(given: ArrayLike) -> tuple[NDArray[np.floating], int]:
    """A copy of the points that were measured, neither NaN nor exact zeros of a camera, shape (n, 3), and how many were not."""
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
        if array.ndim == 3 or np.count_nonzero(measured) < len(rows) - 1:  # a single one may be a point of a list
            rows = rows[measured]
    if n and not len(rows):
        raise InputError("points", f"all {n} are NaN or (0, 0, 0): the sensor saw nothing")
    if len(rows) and not (rows.min() >= -LARGEST and rows.max() <= LARGEST):
        raise InputError("points", f"finite numbers of at most {LARGEST:g} m, or NaN, are expected")
    return rows, n - len(rows)
