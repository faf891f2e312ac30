"""``ulna follow``: computes a joint path through a path of poses."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.cell import Meshes, Obstacles, checked_robot
from ulna.cli.depends import Json, as_options, command, defaults_of
from ulna.cli.options import AnyRobot, Link, TaskName
from ulna.cli.output import Output, PlotFile, attributes, joint_columns, limit, make_table, number, write_figure
from ulna.cli.rows import read_poses
from ulna.cli.targets import ControllerName, StartQ, StatedIn
from ulna.description.controllers import controller_named
from ulna.description.file_bytes import write_table
from ulna.errors import count_of, needs_extra
from ulna.ik.followed_path import FollowedPath
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Poses = Annotated[
    Path,
    typer.Option(
        "--path",
        metavar="FILE",
        help="The poses: rows of x, y, z and roll, pitch, yaw (or w, x, y, z, or a matrix) in a .csv file, or a .npy file.",
    ),
]
Out = Annotated[
    Path | None, typer.Option("--csv", metavar="FILE", help="Write the joint path: a line of names, then one row per pose.")
]
MaxStep = Annotated[float, typer.Option(metavar="NUMBER", help="The largest step of a joint from pose to pose [rad or m].")]
Rank = Annotated[
    str | None, typer.Option(metavar="NAME", help="What is minimized: nearest, manipulability, clearance or mid_range.")
]
TimeLimit = Annotated[float | None, typer.Option(metavar="SECONDS", help="Time limit of the search; none by default.")]

FOLLOW_KEYS = (
    "robot; base; link; task; poses: their number; status; success; reason; sentence; proof: complete or searched; max_step; "
    "largest_step; ends_at: the first pose not reached, from 0, or null; joints; units; lower; upper; q: rows, null "
    "from there on; alive, smallest_step, manipulability, least_singular_value, limit_excess, collisions: why it ends, or null; "
    "files: those that were written."
)
_ENDING = ("alive", "smallest_step", "manipulability", "least_singular_value", "limit_excess", "collisions")
_DEFAULTS = defaults_of(Robot.follow)


@command
def follow(
    robot: AnyRobot,
    link: Link,
    start: StartQ,
    *,
    T_path: Poses,
    frame: StatedIn,
    controller: ControllerName = None,
    world: Obstacles,
    csv: Out = None,
    plot: PlotFile = None,
    task: TaskName = _DEFAULTS["task"],
    max_step: MaxStep = _DEFAULTS["max_step"],
    rank: Rank = None,
    time_limit: TimeLimit = None,
    meshes: Meshes = None,
    as_json: Json = False,
) -> Output:
    """Compute a continuous joint path through a path of poses, or report where and why there is none.

    Example: ulna follow panda --path line.csv --csv joints.csv. To see it move: ulna record line.mp4 --robot panda --trajectory
    joints.csv. With --scene or --box the path avoids the obstacles and self-collision. Without --from the path begins as close to
    home as possible. Exit status 0 if all poses are reached, 1 if not.
    """
    if world is not None:
        robot = checked_robot(robot, meshes=meshes, as_json=as_json)
    poses = read_poses(T_path, None if controller is None else controller_named(controller, "--controller"))
    with as_options({"q_start": "--from", "frame": "--frame"}):
        how = {"task": task, "max_step": max_step, "rank": rank, "time_limit": time_limit}
        found = robot.follow(poses, start, link=link, frame=frame, world=world, **how)
    if csv is not None:
        write_table(csv, found.joint_names, found.q[: found.ends_at])  # the rows that were reached
    if plot is not None:
        write_figure(draw_joints(robot, found), plot)
    data = {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "task": task,
        "poses": len(found.q),
        **attributes(found, "status", "success"),
        "reason": str(found.reason),
        "sentence": str(found),
        **attributes(found, "proof", "max_step"),
        "largest_step": found.steps[np.isfinite(found.steps)].max(initial=0.0),
        "ends_at": found.ends_at,
        **joint_columns(robot),
        **attributes(robot, "lower", "upper"),
        "files": [str(file) for file in (csv, plot) if file is not None],
        "q": found.q,
        **{key: getattr(found.reason.data, key, None) for key in _ENDING},
    }
    return Output(data, follow_table, status=0 if found.success else 1)


def draw_joints(robot: Robot, path: FollowedPath) -> Any:
    """Draw every joint over the poses, with limits near its curve, and the largest steps below; returns a Matplotlib figure."""
    with needs_extra("a figure", "plot", "matplotlib"):
        from ulna.notebook.figure import NotebookFigure  # noqa: PLC0415 -- needs the extra
    entries = coordinates_of(robot)
    figure = NotebookFigure(figsize=(9, 1.2 * (len(entries) + 1) + 1), layout="constrained")
    axes = figure.subplots(len(entries) + 1, 1, sharex=True, squeeze=False)[:, 0]
    for ax, entry, q, *limits in zip(axes, entries, path.q.T, robot.lower, robot.upper, strict=False):
        ax.plot(q)
        low, high = ax.get_ylim()  # the range of the path; a distant limit would flatten the curve
        for bound in limits:
            if low - (high - low) <= bound <= high + (high - low):
                ax.axhline(bound, color="0.7", linewidth=0.8)
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


def follow_table(data) -> Iterator[RenderableType]:
    """Show the first and last position of each joint, its range between the limits, and the status."""
    yield Text(f"{data['robot']}: {data['link']} in {data['base']}, {count_of(data['poses'], 'pose')}", "bold")
    rows = data["q"][: data["ends_at"]]
    if rows:
        table = make_table(["joint"], ["begins", "ends", "min", "max", "lower", "upper", ""], [])
        for k, (name, unit) in enumerate(zip(data["joints"], data["units"], strict=True)):
            q = [row[k] for row in rows]
            limits = map(limit, (data["lower"][k], data["upper"][k]))
            table.add_row(name, *(number(x, 4) for x in (q[0], q[-1], min(q), max(q))), *limits, unit)
        yield table
    yield Text(data["sentence"], "bold green" if data["success"] else "bold red")
    yield from map("written: {}".format, data["files"])
