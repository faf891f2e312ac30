"""The option ``--plot``: draws every joint of a path between its limits. Used by ``follow`` and ``plan``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.errors import FileError, InputError, needs_extra
from ulna.ik.following.result import FollowedPath
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PlotFile = Annotated[
    Path | None, typer.Option("--plot", metavar="FILE", help="Draw every joint between its limits: .png, .svg or .pdf.")
]
_PERIOD = 0.01  # [s]


def draw_path(robot: Robot, path: FollowedPath) -> Figure:
    """Every joint over the poses; below them the largest step of each pose. A red line is where the path ends."""
    figure, below = _draw(robot, np.arange(len(path.q)), path.q, "pose", str(path), rows_below=1)
    below[0].plot(np.arange(len(path.q) - len(path.steps), len(path.q)), path.steps)
    below[0].axhline(path.max_step, color="0.7", linewidth=0.8)
    below[0].set_ylabel("largest step", rotation=0, ha="right", fontsize="small")
    if path.ends_at is not None:
        for ax in figure.axes:
            ax.axvline(path.ends_at, color="red", linewidth=0.8)
    return figure


def draw_motion(robot: Robot, motion: Trajectory) -> Figure:
    """Every joint over time."""
    times = np.append(np.arange(0.0, motion.duration, _PERIOD), motion.duration)
    return _draw(robot, times, motion.at(times).q, "time [s]", str(motion))[0]


def write_figure(figure: Figure, out: Path) -> None:
    """Write a figure: .png, .svg or .pdf.

    Raises:
        InputError: matplotlib cannot write files with this ending.
        FileError: The file cannot be written.
    """
    try:
        figure.savefig(out, dpi=120)
    except ValueError as error:
        raise InputError("--plot", str(error)) from None
    except OSError as error:
        raise FileError(str(out), error.strerror or str(error)) from None


def _draw(robot: Robot, x: NDArray, q: NDArray, label: str, heading: str, rows_below: int = 0) -> tuple[Figure, NDArray]:
    """A figure with a row for each joint, and the axes of the rows below them, which are empty."""
    with needs_extra("a figure", "reach", "matplotlib"):
        from matplotlib.figure import Figure  # noqa: PLC0415 -- needs the extra
    entries = coordinates_of(robot)
    rows = len(entries) + rows_below
    figure = Figure(figsize=(9, 1.2 * rows + 1), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
    for ax, entry, values, lower, upper in zip(axes, entries, q.T, robot.lower, robot.upper, strict=False):
        ax.plot(x, values)
        for limit in (lower, upper):
            if np.isfinite(limit):
                ax.axhline(limit, color="0.7", linewidth=0.8)
        ax.set_ylabel(f"{entry.name} [{entry.unit}]", rotation=0, ha="right", fontsize="small")
    axes[-1].set_xlabel(label)
    figure.suptitle(heading, fontsize="small", wrap=True)
    return figure, axes[len(entries) :]
