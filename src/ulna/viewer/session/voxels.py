"""Selects and colors the voxels of a reachability map, and finds the voxel under the pointer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ulna.reachability.map import ReachabilityMap

Array = NDArray[np.float64]
AXES = ("x", "y", "z")
# Colors from few orientations to all, in equal steps of lightness, for color-blind people too: viridis (S. van der Walt and
# N. Smith, 2015).
RAMP = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], dtype=np.float64)


class Voxels:
    """The voxels of a map with a reached orientation: their centers [m], shape (n, 3), and shares, shape (n,)."""

    def __init__(self, found: ReachabilityMap) -> None:
        share = np.nan_to_num(found.share.values)
        z, y, x = np.nonzero(share > 0.0)
        axes = found.grid.axes
        self.size = found.grid.voxel
        self.centers: Array = np.stack([axes[2][x], axes[1][y], axes[0][z]], axis=-1)
        self.shares: Array = share[z, y, x].astype(np.float64)
        self.colors = _colors(self.shares)

    def ends(self, axis: str) -> tuple[float, float]:
        """The range of a clipping plane along an axis [m]: from before the first voxel to behind the last."""
        if not len(self.centers):
            return 0.0, self.size
        along = self.centers[:, AXES.index(axis)]
        return float(along.min()) - self.size / 2, float(along.max()) + self.size / 2

    def shown(self, axis: str, plane: float, min_share: float) -> NDArray[np.int64]:
        """The indices of the voxels behind a plane normal to an axis, and with at least a share.

        Behind the plane the coordinate is larger.
        """
        return np.flatnonzero((self.centers[:, AXES.index(axis)] >= plane) & (self.shares >= min_share))

    def on_ray(self, origin: Array, direction: Array, shown: NDArray[np.int64]) -> int | None:
        """The first shown voxel on a ray from a point (3,) along a direction (3,); None if there is none.

        Uses the slab test: a ray is inside a cube where it is between all three pairs of planes. Source: T. Kay and J. Kajiya,
        Ray tracing complex scenes (1986).
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (self.centers[shown] - self.size / 2 - origin) / direction
            second = (self.centers[shown] + self.size / 2 - origin) / direction
        enters = np.fmax.reduce(np.fmin(first, second), axis=1)
        leaves = np.fmin.reduce(np.fmax(first, second), axis=1)
        hit = np.flatnonzero((enters <= leaves) & (leaves >= 0.0))
        return int(shown[hit[enters[hit].argmin()]]) if len(hit) else None


def _colors(shares: Array) -> NDArray[np.uint8]:
    places = shares * (len(RAMP) - 1)
    channels = [np.interp(places, np.arange(len(RAMP)), channel) for channel in RAMP.T]
    return np.stack(channels, axis=-1).round().astype(np.uint8)
