"""``ulna ik``: joint positions that bring a link to a pose."""

from collections.abc import Iterator
from math import degrees as in_degrees
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.numbers import RPY, WXYZ, XYZ, numbers
from ulna.cli.options import (
    Base,
    Degrees,
    Json,
    Link,
    PackageDirs,
    RobotName,
    Tip,
    XacroArgs,
    link_or_hand,
    load_robot,
    positions,
)
from ulna.cli.output import Data, count_of, limit, make_table, number, show
from ulna.description.pose import pose, rpy_from_matrix
from ulna.errors import InputError
from ulna.ik.result import IKResult
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Position = Annotated[str, typer.Option(metavar="X,Y,Z", help="The position to reach, in metres.")]
RollPitchYaw = Annotated[
    str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch, yaw; the orientation at home unless given.")
]
Quaternion = Annotated[str | None, typer.Option(metavar="W,X,Y,Z", help="The orientation as a quaternion instead.")]
StartPositions = Annotated[str | None, typer.Option(metavar="NUMBERS", help="Joint positions to start from.")]
Method = Annotated[
    str, typer.Option(metavar="NAME", help="levenberg_marquardt, jacobian_transpose, pseudo_inverse or damped_least_squares.")
]
TaskName = Annotated[str, typer.Option(metavar="NAME", help="pose, position, or pointing: the z axis alone.")]
Trace = Annotated[bool, typer.Option("--trace", help="Show every step.")]
Seed = Annotated[int, typer.Option(min=0, help="Chooses the random starts.")]

IK_KEYS = (
    "robot; base; link; target: matrix, 4x4, and orientation, given or home; method; status; success; joints; units; q; lower; "
    "upper; position_error; rotation_error; residual: x, y, z, rx, ry, rz in the target's axes; task; iterations; starts: number "
    "of the start that led to q; reason; reach_excess, in metres; limit_excess by joint; trace: rows of position error, rotation "
    "error, largest joint step, damping, or null."
)
TRACK_WIDTH = 13  # characters


def ik(
    robot: RobotName = "panda",
    *,
    xyz: Position,
    rpy: RollPitchYaw = None,
    wxyz: Quaternion = None,
    q_seed: StartPositions = None,
    link: Link = None,
    method: Method = "levenberg_marquardt",
    task: TaskName = "pose",
    trace: Trace = False,
    seed: Seed = 0,
    degrees: Degrees = False,
    base: Base = None,
    tip: Tip = None,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Inverse kinematics: joint positions that bring a link to a pose.

    As in: ulna ik --xyz "0.4,0,0.5" --rpy "pi,0,0".
    Exit status 0 if solved, 1 if not. Without --rpy or --wxyz the link keeps the orientation that it has at home.
    """
    arm = load_robot(robot, xacro_arg, package_dir, base=base, tip=tip)
    link = link_or_hand(arm, link, quietly=as_json)
    T, orientation = _target(arm, link, xyz, rpy, wxyz, degrees=degrees)
    start = None if q_seed is None else positions("--q-seed", q_seed, arm, degrees=degrees)
    result = arm.inverse_kinematics(T, start, link=link, method=method, seed=seed, task=task, trace=trace)
    asked = {"method": method, "task": task}
    show(ik_data(arm, link, T, orientation, asked, result), ik_table, as_json=as_json)
    raise typer.Exit(0 if result.success else 1)


def _target(
    robot: Robot, link: str, xyz: str, rpy: str | None, wxyz: str | None, *, degrees: bool
) -> tuple[NDArray[np.float64], str]:
    """The pose to reach, shape (4, 4), and whether its orientation was "given" or is that of "home"."""
    if rpy is not None and wxyz is not None:
        raise InputError("--rpy, --wxyz", "give one of them, not both")
    position = numbers("--xyz", xyz, XYZ)
    if rpy is not None:
        return pose(position, numbers("--rpy", rpy, RPY, degrees=degrees)), "given"
    if wxyz is not None:
        return pose(position, wxyz=numbers("--wxyz", wxyz, WXYZ)), "given"
    T = robot.forward_kinematics(robot.home, link=link)
    T[:3, 3] = position
    return T, "home"


def ik_data(robot: Robot, link: str, T: NDArray[np.float64], orientation: str, asked: dict[str, str], result: IKResult) -> Data:
    """The result of a search for the target T, shape (4, 4), with method and task as ``asked``; see ``IK_KEYS``."""
    return {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "target": {"matrix": T, "orientation": orientation},
        **asked,
        "status": str(result.status),
        "success": bool(result.success),
        "joints": [entry.name for entry in coordinates_of(robot)],
        "units": [entry.unit for entry in coordinates_of(robot)],
        "q": result.q,
        "lower": robot.lower,
        "upper": robot.upper,
        "position_error": float(result.position_error),
        "rotation_error": float(result.rotation_error),
        "residual": result.residual,
        "iterations": int(result.iterations),
        "starts": int(result.starts),
        "reason": str(result.reason),
        "reach_excess": float(result.reach_excess),
        "limit_excess": result.limit_excess,
        "trace": result.trace if result.has_trace else None,
    }


def ik_table(data) -> Iterator[RenderableType]:
    """The target, q between its limits, the steps if they are asked for, and the status."""
    T = np.array(data["target"]["matrix"])
    turn = ", ".join(number(angle) for angle in rpy_from_matrix(T)) + " rad"
    yield Text.assemble(
        (f"{data['robot']}: {data['link']} in {data['base']}", "bold"),
        f"\nposition x, y, z  {', '.join(number(x) for x in T[:3, 3])} m",
        f"\nroll, pitch, yaw  {turn}",
        " (none given: as at home)" if data["target"]["orientation"] == "home" else "",
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
        f": {off[0]} m and {off[1]} rad from the target after {count_of(data['iterations'], 'step')}",
        f"\n{data['reason']}" if data["reason"] else "",
    )


def _trace_table(trace) -> RenderableType:
    """A row for each step."""
    table = make_table([], ["step", "position\nerror [m]", "rotation\nerror [rad]", "largest\njoint step", "damping"], [])
    for k, row in enumerate(trace):
        table.add_row(str(k), *(f"{value:.3g}" for value in row))
    return table


def _track(value: float, lower: float | None, upper: float | None) -> str:
    """A number between its limits, drawn as a dot on a line."""
    if lower is None or upper is None or upper <= lower:
        return ""
    place = round((value - lower) / (upper - lower) * (TRACK_WIDTH - 1))
    return "─" * place + "●" + "─" * (TRACK_WIDTH - 1 - place)
