"""Simulates a depth camera that looks at a bin with parts on a table: rays against boxes, with noise."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ulna

Array = NDArray[np.float64]
EYE, LOOKS_AT = np.array([1.25, 0.45, 1.05]), np.array([0.5, 0.0, 0.0])  # [m]
NOISE = 0.001  # [m], standard deviation of a depth
OPENING = 0.9  # focal length in image widths
BAND = 1 << 17  # pixels whose rays are computed together


@dataclass(frozen=True)
class Camera:
    """An image's size in pixels, its intrinsics (fx, fy, cx, cy) and T_base_camera."""

    width: int
    height: int
    intrinsics: tuple[float, float, float, float]
    pose: Array

    @classmethod
    def of_pixels(cls, n: int) -> "Camera":
        """A camera of about n pixels, aspect 4:3, that looks at the bin."""
        width = max(4, round(np.sqrt(n / 0.75)))
        height = max(3, n // width)
        focal = OPENING * width
        z = (LOOKS_AT - EYE) / np.linalg.norm(LOOKS_AT - EYE)
        x = np.cross(z, (0, 0, 1))
        x /= np.linalg.norm(x)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = np.column_stack([x, np.cross(z, x), z]), EYE
        return cls(width, height, (focal, focal, (width - 1) / 2, (height - 1) / 2), T)

    def image(self, boxes: Iterable[tuple[Array, Array]], rng: np.random.Generator | None = None) -> NDArray[np.float32]:
        """The depth of each pixel's first box [m], 0 without one, shape (height, width).

        boxes: half the extents and T_base_box of each; rng: the source of noise, none by default.
        """
        boxes, bands = [*boxes], np.array_split(np.arange(self.height), -(-self.width * self.height // BAND))
        depth = np.concatenate([self._enters(rows, boxes) for rows in bands])
        noise = 0.0 if rng is None else NOISE * rng.normal(size=depth.shape)
        return np.where(np.isfinite(depth), depth + noise, 0).astype(np.float32)

    def _enters(self, rows: NDArray[np.intp], boxes: Iterable[tuple[Array, Array]]) -> Array:
        """The depth of the first box for some rows of pixels, infinite without one."""
        fx, fy, cx, cy = self.intrinsics
        u, v = np.meshgrid((np.arange(self.width) - cx) / fx, (rows - cy) / fy)
        rays, depth = np.stack([u, v, np.ones_like(u)], axis=-1), np.full(u.shape, np.inf)  # of depth 1
        for half, T in boxes:
            T_box_camera = np.linalg.inv(T) @ self.pose
            ray, eye = rays @ T_box_camera[:3, :3].T, T_box_camera[:3, 3]
            with np.errstate(divide="ignore", invalid="ignore"):
                first, second = (-half - eye) / ray, (half - eye) / ray
            enters, leaves = np.minimum(first, second).max(axis=-1), np.maximum(first, second).min(axis=-1)
            depth = np.where((enters <= leaves) & (enters > 0), np.minimum(depth, enters), depth)
        return depth

    def cloud(self, image: NDArray[np.float32], radius: float) -> ulna.PointCloud:
        """The balls around the points of an image."""
        return ulna.PointCloud.from_depth(image, self.intrinsics, self.pose, radius=radius)


def bin_on_a_table(seed: int, parts: int = 8) -> list[tuple[Array, Array]]:
    """A table, a bin's walls, parts in it and posts: half the extents [m] and T_base_box of each box."""
    rng, wall = np.random.default_rng(seed), 0.01
    (x0, y0), (x1, y1), high = (0.40, -0.20), (0.70, 0.20), 0.15
    boxes = [
        ((0.25, -0.6, -0.02), (1.0, 0.6, 0.0)),
        ((x0, y0, 0), (x0 + wall, y1, high)),
        ((x1 - wall, y0, 0), (x1, y1, high)),
        ((x0, y0, 0), (x1, y0 + wall, high)),
        ((x0, y1 - wall, 0), (x1, y1, high)),
    ]
    for _ in range(parts):
        half = rng.uniform(0.015, 0.035, 3)
        middle = np.array([*rng.uniform((0.45, -0.15), (0.65, 0.15)), half[2]])
        boxes.append((middle - half, middle + half))
    for side in (-1, 1, 1):
        middle, half = np.array([rng.uniform(0.35, 0.6), side * rng.uniform(0.35, 0.5), 0.12]), np.array([0.04, 0.04, 0.12])
        boxes.append((middle - half, middle + half))
    return [(np.subtract(upper, lower) / 2, ulna.pose(np.add(lower, upper) / 2)) for lower, upper in boxes]
