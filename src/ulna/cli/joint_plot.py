"""The option ``--plot``: draws a joint path over its poses, and writes a figure."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ulna.errors import FileError, InputError, needs_extra
from ulna.ik.followed_path import FollowedPath
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

PlotFile = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw the joints: .png, .svg or .pdf.")]


def draw_joints(robot: Robot, path: FollowedPath) -> Any:
    """A Matplotlib figure of every joint over the poses, with its limits where they are near; below, the largest steps."""
    with needs_extra("a figure", "reach", "matplotlib"):
        from matplotlib.figure import Figure  # noqa: PLC0415 -- needs the extra
    entries = coordinates_of(robot)
    figure = Figure(figsize=(9, 1.2 * (len(entries) + 1) + 1), layout="constrained")
    axes = figure.subplots(len(entries) + 1, 1, sharex=True, squeeze=False)[:, 0]
    for ax, entry, q, *limits in zip(axes, entries, path.q.T, robot.lower, robot.upper, strict=False):
        ax.plot(q)
        low, high = ax.get_ylim()  # of the path: a limit far from it would flatten it
        for limit in limits:
            if low - (high - low) <= limit <= high + (high - low):
                ax.axhline(limit, color="0.7", linewidth=0.8)
        ax.set_ylabel(f"{entry.name} [{entry.unit}]", rotation=0, ha="right", fontsize="small")
    units = " or ".join(dict.fromkeys(entry.unit for entry in entries))
    axes[-1].plot(np.arange(len(path.q) - len(path.steps), len(path.q)), path.steps)
    axes[-1].axhline(path.max_step, color="0.7", linewidth=0.8)
    axes[-1].set_ylabel(f"largest step [{units}]", rotation=0, ha="right", fontsize="small")
    axes[-1].set_xlabel("pose")
    if path.ends_at is not None:
        for ax in axes:
            ax.axvline(path.ends_at, color="red", linewidth=0.8)
    figure.suptitle(str(path), fontsize="small", wrap=True)
    return figure


def write_figure(figure: Any, out: Path) -> None:
    """Write a Matplotlib figure: .png, .svg or .pdf.

    Raises:
        InputError: Matplotlib cannot write files with this ending.
        FileError: The file cannot be written.
    """
    try:
        figure.savefig(out, dpi=120)
    except ValueError as error:
        raise InputError("--plot", str(error)) from None
    except OSError as error:
        raise FileError(str(out), error.strerror or str(error)) from None
