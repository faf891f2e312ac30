"""Holds the poses of a map: voxels times orientations, cut into chunks.

The orientations are spread evenly over SO(3) by super-Fibonacci spirals: point i of n lies on a spiral of the 3-sphere, whose two
angles grow by irrational ratios.

Source: M. Alexa, "Super-Fibonacci Spirals: Fast, Low-Discrepancy Sampling of SO(3)", CVPR 2022, algorithm 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.arrays import as_count, as_floats, positive
from ulna.description.pose import matrix_from_quaternion, quaternion_from_matrix
from ulna.errors import InputError

Array = NDArray[np.float64]
Region = tuple[slice, ...]
POSES_OF_A_CHUNK = 4096
_PHI = np.sqrt(2.0)
_PSI = 1.533751168755204288118041  # the real root of psi^4 = psi + 4
_AT_ONCE = 1 << 22  # products of quaternions in memory at once
_MAX_POSES = 2**40  # poses of a map


@dataclass(frozen=True)
class Grid:
    """Cubes of one size, each with the same orientations to try at its center.

    Attributes:
        low: The lowest corner of the first voxel in the robot's base frame [m].
        voxel: The length of an edge [m].
        shape: The number of voxels along z, y and x, in this order.
        orientations: The number of orientations to try in each voxel.
        chunk_poses: The maximum number of poses of a chunk.

    Raises:
        InputError: The voxel is not a length above 0, a count is below 1, or there would be more than 2^40 poses.
    """

    low: tuple[float, float, float]
    voxel: float
    shape: tuple[int, int, int]
    orientations: int
    chunk_poses: int = POSES_OF_A_CHUNK

    def __post_init__(self) -> None:
        object.__setattr__(self, "voxel", positive("voxel", self.voxel))
        for name in ("orientations", "chunk_poses"):
            as_count(name, getattr(self, name), 1)
        low = as_floats("low", self.low)
        if low.shape != (3,) or not np.isfinite(low).all():
            raise InputError("low", "a corner of three finite numbers is expected")
        if len(self.shape) != 3 or min(as_count("bounds", n) for n in self.shape) < 1:
            raise InputError("bounds", "there is no voxel between them")
        if not math.isfinite(max(map(abs, low.tolist())) + max(self.shape) * self.voxel):
            raise InputError("voxel", f"{self.voxel!r}; the corners of the map are not finite")
        if self.n_poses > _MAX_POSES:
            raise InputError("voxel", f"{self.n_poses:.3g} poses; a map holds at most {_MAX_POSES:.3g}")

    @classmethod
    def within(cls, bounds: ArrayLike, voxel: float, orientations: int) -> Grid:
        """The voxels that cover a box, the first at its lowest corner.

        bounds: The lowest and the highest corner [m], shape (2, 3).

        Raises:
            InputError: The bounds are not two such corners, or an argument is invalid for the class.
        """
        corners, voxel = as_floats("bounds", bounds), positive("voxel", voxel)
        if corners.shape != (2, 3) or not np.isfinite(corners).all() or not (corners[1] > corners[0]).all():
            raise InputError("bounds", "the lowest and the highest corner are expected, shape (2, 3), all finite")
        counts = [max(1, math.ceil(float(length) / voxel - 1e-6)) for length in corners[1] - corners[0]]
        return cls(tuple(corners[0].tolist()), voxel, (counts[2], counts[1], counts[0]), orientations, POSES_OF_A_CHUNK)

    @property
    def n_poses(self) -> int:
        """The number of poses."""
        return math.prod(self.shape) * self.orientations

    @cached_property
    def axes(self) -> tuple[Array, Array, Array]:
        """The centers of the voxels along z, y and x [m]."""
        return tuple(low + (np.arange(n) + 0.5) * self.voxel for low, n in zip(self.low[::-1], self.shape, strict=True))  # type: ignore[return-value]

    @cached_property
    def wxyz(self) -> Array:
        """The orientations as quaternions, w first: shape (orientations, 4)."""
        return super_fibonacci(self.orientations)

    @cached_property
    def rotations(self) -> Array:
        """The orientations as matrices: shape (orientations, 3, 3)."""
        return matrix_from_quaternion(self.wxyz)

    # ---- chunks --------------------------------------------------------------------------------------------------------

    @cached_property
    def chunk_shape(self) -> tuple[int, int, int, int]:
        """The numbers of voxels along z, y, x, and of orientations, in a chunk of at most ``chunk_poses`` poses."""
        room, shape = self.chunk_poses, []
        for n in (self.orientations, *self.shape[::-1]):
            shape.append(min(n, max(1, room)))
            room //= shape[-1]
        return tuple(shape[::-1])  # type: ignore[return-value]

    @cached_property
    def n_chunks_along(self) -> tuple[int, int, int, int]:
        """The number of chunks along z, y, x and the orientations."""
        return tuple(-(-n // c) for n, c in zip((*self.shape, self.orientations), self.chunk_shape, strict=True))  # type: ignore[return-value]

    @property
    def n_chunks(self) -> int:
        """The number of chunks."""
        return math.prod(self.n_chunks_along)

    def place(self, chunk: int) -> tuple[int, int, int, int]:
        """The indices of a chunk among the chunks along z, y, x and the orientations."""
        return tuple(int(k) for k in np.unravel_index(chunk, self.n_chunks_along))  # type: ignore[return-value]

    def region(self, chunk: int) -> Region:
        """The slices of a map's arrays that form a chunk."""
        ends = zip(self.place(chunk), self.chunk_shape, (*self.shape, self.orientations), strict=True)
        return tuple(slice(k * size, min((k + 1) * size, n)) for k, size, n in ends)  # type: ignore[return-value]

    def poses_of(self, chunk: int) -> int:
        """The number of poses of a chunk."""
        return math.prod(cut.stop - cut.start for cut in self.region(chunk))

    def targets(self, region: Region) -> Array:
        """T_base_tip of the poses of a region, in the order (z, y, x, orientation): shape (n, 4, 4)."""
        z, y, x = (axis[cut] for axis, cut in zip(self.axes, region[:3], strict=True))
        R = self.rotations[region[3]]
        T = np.zeros((len(z), len(y), len(x), len(R), 4, 4))
        T[..., :3, :3], T[..., 3, 3] = R, 1.0
        T[..., 0, 3], T[..., 1, 3], T[..., 2, 3] = x[:, None], y[:, None, None], z[:, None, None, None]
        return T.reshape(-1, 4, 4)

    # ---- where a pose lies ---------------------------------------------------------------------------------------------

    def voxel_of(self, points: Array) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """The voxel (z, y, x) of each point [m], shape (..., 3) each, and whether the point is inside.

        A point outside gets the nearest voxel.
        """
        index = np.floor((points - np.array(self.low)) / self.voxel)[..., ::-1]
        last = np.array(self.shape) - 1
        inside = ((index >= 0) & (index <= last)).all(axis=-1)
        return np.clip(index, 0, last).astype(np.int64), np.asarray(inside)


def super_fibonacci(n: int) -> Array:
    """n unit quaternions, w first, spread evenly over SO(3): shape (n, 4).

    Example:
        >>> super_fibonacci(64).shape
        (64, 4)
    """
    s = np.arange(n) + 0.5
    r, R = np.sqrt(s / n), np.sqrt(1.0 - s / n)
    alpha, beta = 2.0 * np.pi * s / _PHI, 2.0 * np.pi * s / _PSI
    return np.stack([R * np.cos(beta), r * np.sin(alpha), r * np.cos(alpha), R * np.sin(beta)], axis=-1)


def nearest_orientation(T: Array, wxyz: Array) -> NDArray[np.int64]:
    """The index of the nearest of the quaternions (n, 4) to each pose or rotation (m, k, k): shape (m,).

    The metric is the angle between them, 2 arccos |a . b|: a quaternion and its negative are the same rotation.
    """
    quaternions = quaternion_from_matrix(T)
    step = max(1, _AT_ONCE // len(wxyz))
    parts = [np.abs(quaternions[k : k + step] @ wxyz.T).argmax(axis=1) for k in range(0, len(quaternions), step)]
    return np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)
