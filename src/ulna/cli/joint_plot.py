"""Draws a joint path over its poses. Used by ``follow``."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ulna.errors import FileError, InputError
from ulna.ik.following.result import FollowedPath
from ulna.robot import Robot


def draw_joints(robot: Robot, path: FollowedPath) -> Figure:
    """Every joint over the poses, with its limits; below them the largest step of each pose."""
    names = path.joint_names
    figure = Figure(figsize=(9, 1.2 * (len(names) + 1) + 1), layout="constrained")
    axes = figure.subplots(len(names) + 1, 1, sharex=True, squeeze=False)[:, 0]
    for ax, name, q, lower, upper in zip(axes, names, path.q.T, robot.lower, robot.upper, strict=False):
        ax.plot(q)
        for limit in (lower, upper):
            if np.isfinite(limit):
                ax.axhline(limit, color="0.7", linewidth=0.8)
        ax.set_ylabel(name, rotation=0, ha="right", fontsize="small")
    axes[-1].plot(np.arange(len(path.q) - len(path.steps), len(path.q)), path.steps)
    axes[-1].axhline(path.max_step, color="0.7", linewidth=0.8)
    axes[-1].set_ylabel("largest step", rotation=0, ha="right", fontsize="small")
    axes[-1].set_xlabel("pose")
    if path.ends_at is not None:
        for ax in axes:
            ax.axvline(path.ends_at, color="red", linewidth=0.8)
    figure.suptitle(str(path), fontsize="small", wrap=True)
    return figure


def write_joints(robot: Robot, path: FollowedPath, out: Path) -> None:
    """Write that figure: .png, .svg or .pdf.

    Raises:
        InputError: matplotlib cannot write files with this ending.
        FileError: The file cannot be written.
    """
    try:
        draw_joints(robot, path).savefig(out, dpi=120)
    except ValueError as error:
        raise InputError("--plot", str(error)) from None
    except OSError as error:
        raise FileError(str(out), error.strerror or str(error)) from None
