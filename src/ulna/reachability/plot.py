"""Draws the figures of a map."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ulna.notebook.figure import NotebookFigure
from ulna.reachability.map import ReachabilityMap

_COLORS = "viridis"


def draw(found: ReachabilityMap) -> NotebookFigure:
    """Draw three slices through the middle of the reached voxels, the share by height, and the statuses of other poses."""
    figure = NotebookFigure(figsize=(12, 7), layout="constrained")
    axes = figure.subplots(2, 3)
    center = _center(found)
    for ax, axis in zip(axes[0], "xyz", strict=True):
        _draw_slice(ax, found, axis, center["xyz".index(axis)])
    figure.colorbar(axes[0, 0].images[0], ax=axes[0], label="share of orientations reached")
    _draw_by_height(axes[1, 0], found)
    _draw_shares(axes[1, 1], found)
    _draw_statuses(axes[1, 2], found)
    figure.suptitle(f"{found.attributes['robot']}: {found.link}, {found.grid.n_poses:,} poses")
    return figure


def _center(found: ReachabilityMap) -> tuple[float, float, float]:
    """The position of the cuts, x, y, z [m]: the share-weighted mean of the reached voxels, rounded to voxels."""
    weights = np.nan_to_num(found.share.values)
    weights = weights if weights.sum() > 0.0 else np.ones_like(weights)
    z, y, x = (np.average(c, weights=weights.sum(axis=tuple({0, 1, 2} - {k}))) for k, c in enumerate(found.grid.axes))
    step = found.grid.voxel
    return step * round(x / step), step * round(y / step), step * round(z / step)


def _draw_slice(ax: Axes, found: ReachabilityMap, axis: str, value: float) -> None:
    """Draw the share in a plane, interpolated between voxels; the picture ends at the voxels' edges."""
    places = found.share[axis].values
    at = float(np.interp(value, places, np.arange(len(places))))  # between two layers
    lower, upper = int(at), min(int(at) + 1, len(places) - 1)
    cut = (lower + 1 - at) * found.share.isel({axis: lower}) + (at - lower) * found.share.isel({axis: upper})
    across, up = (name for name in "xyz" if name != axis)
    half = found.grid.voxel / 2
    edges = [edge for name in (across, up) for edge in (float(cut[name][0]) - half, float(cut[name][-1]) + half)]
    look = {"vmin": 0.0, "vmax": 1.0, "cmap": _COLORS, "interpolation": "bilinear", "aspect": "equal"}
    ax.imshow(cut.transpose(up, across).values, origin="lower", extent=tuple(edges), **look)  # type: ignore[arg-type]
    ax.set(title=f"{axis} = {round(value, 4):g} m", xlabel=f"{across} [m]", ylabel=f"{up} [m]")


def _draw_by_height(ax: Axes, found: ReachabilityMap) -> None:
    share = found.share
    ax.plot(share.mean(dim=("y", "x"), skipna=True), share["z"])  # of the computed poses
    ax.set(xlabel="share of poses reached", ylabel="z [m]", title="by height")


def _draw_shares(ax: Axes, found: ReachabilityMap) -> None:
    share = found.share.values
    counts, edges = np.histogram(share[share > 0.0], bins=10, range=(0.0, 1.0))
    ax.bar(edges[:-1], counts * found.grid.voxel**3, width=0.1, align="edge")
    ax.set(xlabel="share of orientations reached", ylabel="volume [m³]", title="dexterity")


def _draw_statuses(ax: Axes, found: ReachabilityMap) -> None:
    statuses = found.summary.statuses
    names = ["reached" if name == "solved" else name for name in statuses]
    ax.barh(names, [count / max(1, found.summary.computed) for count in statuses.values()])
    ax.set(xlabel="share of poses", title="statuses")
