"""``ulna ik``: joint positions that bring a link to a pose."""

from collections.abc import Iterator
from math import degrees as in_degrees
from typing import Annotated

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import as_options, command, defaults_of
from ulna.cli.options import AnyRobot, Link, Seed, TaskName
from ulna.cli.output import Output, attributes, joint_columns, limit, make_table, number
from ulna.cli.targets import StartQ, TargetPose, target_pose
from ulna.description.pose import rpy_from_matrix
from ulna.errors import count_of
from ulna.robot import Robot

Position = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="The position to reach, in meters.")]
Trace = Annotated[bool, typer.Option("--trace", help="Show every step.")]

IK_KEYS = (
    "robot; base; link; target: matrix, 4x4, orientation, given or home, and frame, a link, a matrix or null; status; "
    "success; joints; units; q; lower; upper; position_error; rotation_error; residual: x, y, z, rx, ry, rz in the axes of the "
    "target; task; iterations; starts: index of the start that led to q; reason; reach_excess, in meters; limit_excess by "
    "joint; trace: rows of position error, rotation error, largest joint step, damping, or null."
)
TRACK_WIDTH = 13  # characters
_DEFAULTS = defaults_of(Robot.inverse_kinematics)


@command
def ik(
    robot: AnyRobot,
    link: Link,
    start: StartQ,
    *,
    xyz: Position = None,
    target: TargetPose,
    task: TaskName = _DEFAULTS["task"],
    trace: Trace = False,
    seed: Seed = _DEFAULTS["seed"],
) -> Output:
    """Inverse kinematics: print joint positions that bring a link to a pose.

    Example: ulna ik --xyz "0.4,0,0.5" --rpy "pi,0,0", or ulna ik --pose "400,0,500,0,180,0" --controller KUKA. Exit status 0 if
    solved, 1 if not. Without --rpy, --wxyz or --rotvec the link keeps its orientation at home.
    """
    T = target_pose(robot, link, xyz, target)
    is_turned = target.whole is not None or target.orientation is not None
    with as_options({"q_seed": "--from", "frame": "--frame"}):
        how = {"seed": seed, "task": task, "trace": trace}
        result = robot.inverse_kinematics(T, start, link=link, frame=target.frame, **how)
    data = {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "target": {"matrix": T, "orientation": "given" if is_turned else "home", "frame": target.frame},
        "task": task,
        **attributes(result, "status", "success"),
        **joint_columns(robot),
        "q": result.q,
        **attributes(robot, "lower", "upper"),
        **attributes(result, "position_error", "rotation_error", "residual", "iterations", "starts"),
        "reason": str(result.reason),
        **attributes(result, "reach_excess", "limit_excess"),
        "trace": result.trace if result.has_trace else None,
    }
    return Output(data, ik_table, status=0 if result.success else 1)


def ik_table(data) -> Iterator[RenderableType]:
    """Show the target, q between its limits, the steps on request, and the status."""
    T = np.array(data["target"]["matrix"])
    turn = ", ".join(number(angle) for angle in rpy_from_matrix(T)) + " rad"
    yield Text.assemble(
        (f"{data['robot']}: {data['link']} in {data['base']}", "bold"),
        f"\nposition x, y, z  {', '.join(number(x) for x in T[:3, 3])} m",
        f"\nroll, pitch, yaw  {turn}",
        " (not given: as at home)" if data["target"]["orientation"] == "home" else "",
    )
    table = make_table(["joint"], ["q", "", "deg", "lower", "upper"], ["within its limits"])
    for name, unit, q, *limits in zip(*(data[key] for key in ("joints", "units", "q", "lower", "upper")), strict=True):
        turned = number(in_degrees(q), 2) if unit == "rad" else ""
        table.add_row(name, number(q), unit, turned, *map(limit, limits), _track(q, *limits))
    yield table
    if data["trace"] is not None:
        yield _trace_table(data["trace"])
    off = ["inf" if data[key] is None else f"{data[key]:.2g}" for key in ("position_error", "rotation_error")]
    yield Text.assemble(
        (data["status"], "bold green" if data["success"] else "bold red"),
        ": within what the task allows," if data["success"] and data["task"] != "pose" else ":",
        f" {off[0]} m and {off[1]} rad from the target after {count_of(data['iterations'], 'step')}",
        f"\n{data['reason']}" if data["reason"] else "",
    )


def _trace_table(trace) -> RenderableType:
    """Show a row for each step."""
    table = make_table([], ["step", "position\nerror [m]", "rotation\nerror [rad]", "largest\njoint step", "damping"], [])
    for k, row in enumerate(trace):
        table.add_row(str(k), *(f"{value:.3g}" for value in row))
    return table


def _track(value: float, lower: float | None, upper: float | None) -> str:
    """Draw a number between its limits as a dot on a line."""
    if lower is None or upper is None or upper <= lower:
        return ""
    place = round((value - lower) / (upper - lower) * (TRACK_WIDTH - 1))
    return "─" * place + "●" + "─" * (TRACK_WIDTH - 1 - place)
