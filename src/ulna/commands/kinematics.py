"""``ulna fk``, ``ulna jacobian`` and ``ulna ik``: where a robot is, how it moves, and how it gets there."""

from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

import ulna
from ulna.answers.kinematics import ik_data, jacobian_data, pose_data
from ulna.commands.numbers import RPY, WXYZ, XYZ, numbers
from ulna.commands.options import Degrees, Json, Link, PackageDirs, Positions, RobotName, XacroArgs, load_robot, positions
from ulna.errors import InputError
from ulna.tables.kinematics import ik_view, jacobian_view, pose_view
from ulna.tables.writing import show


def fk(
    robot: RobotName = "panda",
    *,
    q: Positions = None,
    link: Link = None,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Forward kinematics: where a link is.

    As in: ulna fk --q "0,-pi/4,0,-3pi/4,0,pi/2,pi/4".
    """
    arm = load_robot(robot, xacro_arg, package_dir)
    at = positions("--q", q, arm, degrees=degrees)
    T = arm.forward_kinematics(at, link)
    show(pose_data(arm, at, link or str(arm.tip), T), None if as_json else pose_view)


def jacobian(
    robot: RobotName = "panda",
    *,
    q: Positions = None,
    link: Link = None,
    expressed_in: Annotated[str | None, typer.Option(metavar="FRAME", help="base, link or spatial; base unless given.")] = None,
    analytical: Annotated[bool, typer.Option("--analytical", help="Rates of x, y, z, roll, pitch, yaw instead.")] = False,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """The Jacobian: how fast a link moves for a unit rate of each joint.

    Rows are linear first, then angular: metres and radians per second.
    """
    arm = load_robot(robot, xacro_arg, package_dir)
    at = positions("--q", q, arm, degrees=degrees)
    if analytical and expressed_in is not None:
        raise InputError("--expressed-in", "goes with the geometric Jacobian, not with --analytical")
    frame = None if analytical else "base" if expressed_in is None else expressed_in
    J = arm.analytical_jacobian(at, link) if frame is None else arm.jacobian(at, link, frame)
    show(jacobian_data(arm, at, link or str(arm.tip), J, frame), None if as_json else jacobian_view)


def ik(
    robot: RobotName = "panda",
    *,
    xyz: Annotated[str, typer.Option(metavar="X,Y,Z", help="The position to reach, in metres.")],
    rpy: Annotated[
        str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch, yaw; the orientation at home unless given.")
    ] = None,
    wxyz: Annotated[str | None, typer.Option(metavar="W,X,Y,Z", help="The orientation as a quaternion instead.")] = None,
    q_seed: Annotated[str | None, typer.Option(metavar="NUMBERS", help="Joint positions to start from.")] = None,
    link: Link = None,
    method: Annotated[
        str,
        typer.Option(metavar="NAME", help="levenberg_marquardt, jacobian_transpose, pseudo_inverse or damped_least_squares."),
    ] = "levenberg_marquardt",
    task: Annotated[str, typer.Option(metavar="NAME", help="pose, position, or pointing: the z axis alone.")] = "pose",
    trace: Annotated[bool, typer.Option("--trace", help="Show every step.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Chooses the random starts.")] = 0,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Inverse kinematics: joint positions that bring a link to a pose.

    As in: ulna ik --xyz "0.4,0,0.5" --rpy "pi,0,0".
    Exit status 0 if solved, 1 if not. Without --rpy or --wxyz the link keeps the orientation that it has at home.
    """
    arm = load_robot(robot, xacro_arg, package_dir)
    T, orientation = _target(arm, link, xyz, rpy, wxyz, degrees=degrees)
    start = None if q_seed is None else positions("--q-seed", q_seed, arm, degrees=degrees)
    result = arm.inverse_kinematics(T, start, link, method, seed, task=task, trace=trace)
    asked = {"method": method, "task": task}
    show(ik_data(arm, link or str(arm.tip), T, orientation, asked, result), None if as_json else ik_view)
    raise typer.Exit(0 if result.success else 1)


def _target(
    robot: ulna.Robot, link: str | None, xyz: str, rpy: str | None, wxyz: str | None, *, degrees: bool
) -> tuple[NDArray[np.float64], str]:
    """The pose to reach, and whether its orientation was "given" or is that of "home"."""
    if rpy is not None and wxyz is not None:
        raise InputError("--rpy, --wxyz", "give one of them, not both")
    position = numbers("--xyz", xyz, XYZ)
    if rpy is not None:
        return ulna.pose(position, numbers("--rpy", rpy, RPY, degrees=degrees)), "given"
    if wxyz is not None:
        return ulna.pose(position, wxyz=numbers("--wxyz", wxyz, WXYZ)), "given"
    T = robot.forward_kinematics(robot.home, link)
    T[:3, 3] = position
    return T, "home"
