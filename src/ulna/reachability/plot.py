"""Draws the figures of a map."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ulna.notebook.figure import NotebookFigure
from ulna.reachability.map import ReachabilityMap

_COLORS = "viridis"


def draw(reach_map: ReachabilityMap) -> NotebookFigure:
    """Draw three slices through the middle of the reached voxels, the share by height, and the statuses of other poses."""
    figure = NotebookFigure(figsize=(12, 7), layout="constrained")
    axes = figure.subplots(2, 3)
    center = _center(reach_map)
    for ax, axis in zip(axes[0], "xyz", strict=True):
        _draw_slice(ax, reach_map, axis, center["xyz".index(axis)])
    figure.colorbar(axes[0, 0].images[0], ax=axes[0], label="share of orientations reached")
    _draw_by_height(axes[1, 0], reach_map)
    _draw_shares(axes[1, 1], reach_map)
    _draw_statuses(axes[1, 2], reach_map)
    figure.suptitle(f"{reach_map.attributes['robot']}: {reach_map.link}, {reach_map.grid.n_poses:,} poses")
    return figure


def _center(reach_map: ReachabilityMap) -> tuple[float, float, float]:
    """The position of the cuts, x, y, z [m]: the share-weighted mean of the reached voxels, rounded to voxels."""
    weights = np.nan_to_num(reach_map.share.values)
    weights = weights if weights.sum() > 0.0 else np.ones_like(weights)
    z, y, x = (np.average(c, weights=weights.sum(axis=tuple({0, 1, 2} - {k}))) for k, c in enumerate(reach_map.grid.axes))
    step = reach_map.grid.voxel
    return step * round(x / step), step * round(y / step), step * round(z / step)


def _draw_slice(ax: Axes, reach_map: ReachabilityMap, axis: str, value: float) -> None:
    """Draw the share in a plane, interpolated between voxels; the picture ends at the voxels' edges."""
    places = reach_map.share[axis].values
    layer = float(np.interp(value, places, np.arange(len(places))))  # between two layers
    lower, upper = int(layer), min(int(layer) + 1, len(places) - 1)
    plane = (lower + 1 - layer) * reach_map.share.isel({axis: lower}) + (layer - lower) * reach_map.share.isel({axis: upper})
    horizontal, vertical = (name for name in "xyz" if name != axis)
    half = reach_map.grid.voxel / 2
    edges = [edge for name in (horizontal, vertical) for edge in (float(plane[name][0]) - half, float(plane[name][-1]) + half)]
    style = {"vmin": 0.0, "vmax": 1.0, "cmap": _COLORS, "interpolation": "bilinear", "aspect": "equal"}
    ax.imshow(plane.transpose(vertical, horizontal).values, origin="lower", extent=tuple(edges), **style)  # type: ignore[arg-type]
    ax.set(title=f"{axis} = {round(value, 4):g} m", xlabel=f"{horizontal} [m]", ylabel=f"{vertical} [m]")


def _draw_by_height(ax: Axes, reach_map: ReachabilityMap) -> None:
    share = reach_map.share
    ax.plot(share.mean(dim=("y", "x"), skipna=True), share["z"])  # of the computed poses
    ax.set(xlabel="share of poses reached", ylabel="z [m]", title="by height")


def _draw_shares(ax: Axes, reach_map: ReachabilityMap) -> None:
    share = reach_map.share.values
    counts, edges = np.histogram(share[share > 0.0], bins=10, range=(0.0, 1.0))
    ax.bar(edges[:-1], counts * reach_map.grid.voxel**3, width=0.1, align="edge")
    ax.set(xlabel="share of orientations reached", ylabel="volume [m³]", title="dexterity")


def _draw_statuses(ax: Axes, reach_map: ReachabilityMap) -> None:
    statuses = reach_map.summary.statuses
    names = ["reached" if name == "solved" else name for name in statuses]
    ax.barh(names, [count / max(1, reach_map.summary.computed) for count in statuses.values()])
    ax.set(xlabel="share of poses", title="statuses")
