"""Reads a q or a pose from the command line: ``--q``, ``--from``, ``--xyz``, ``--rpy``, ``--wxyz``."""

from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.cli.depends import Depends
from ulna.cli.numbers import RPY, WXYZ, XYZ, is_name, numbers
from ulna.cli.options import AnyRobot, Degrees
from ulna.description.pose import pose
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.groups import JointGroup, state_named
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Array = NDArray[np.float64]
HOME = "home"

Positions = Annotated[
    str | None,
    typer.Option(
        "--q", metavar="NUMBERS", help='Joint positions, as in "0,-pi/4,0.5 1e-3", or a state of the SRDF; home unless given.'
    ),
]
Start = Annotated[
    str | None,
    typer.Option("--from", metavar="NUMBERS", help="Joint positions to start from, or a state of the SRDF, or home."),
]
RollPitchYaw = Annotated[
    str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch, yaw; the orientation at home unless given.")
]
Quaternion = Annotated[str | None, typer.Option(metavar="W,X,Y,Z", help="The orientation as a quaternion instead.")]


def q_of(robot: AnyRobot, *, q: Positions = None, degrees: Degrees = False) -> Array:
    """The q of ``--q`` [rad or m], shape (n_dof,); home without it."""
    return robot.home if q is None else positions("--q", q, robot, degrees=degrees)


Q = Annotated[Array, Depends(q_of)]


def start_of(robot: AnyRobot, *, start: Start = None, degrees: Degrees = False) -> Array | None:
    """The q of ``--from`` [rad or m], shape (n_dof,); None without it."""
    return None if start is None else positions("--from", start, robot, degrees=degrees)


StartQ = Annotated[Array | None, Depends(start_of)]


def orientation_of(*, rpy: RollPitchYaw = None, wxyz: Quaternion = None, degrees: Degrees = False) -> Array | None:
    """The orientation of ``--rpy`` or ``--wxyz`` as a pose at the origin, shape (4, 4); None without them.

    Raises:
        InputError: Both are given, or they are not numbers.
    """
    if rpy is not None and wxyz is not None:
        raise InputError("--rpy, --wxyz", "give one of them, not both")
    if wxyz is not None:
        return pose(wxyz=numbers("--wxyz", wxyz, WXYZ))
    return None if rpy is None else pose(rpy=numbers("--rpy", rpy, RPY, degrees=degrees))


Orientation = Annotated[Array | None, Depends(orientation_of)]


def target_pose(robot: Robot, link: str, xyz: str, orientation: Array | None) -> Array:
    """The pose of ``--xyz``, shape (4, 4); the link is turned as at home unless an orientation is given."""
    T = robot.forward_kinematics(robot.home, link=link) if orientation is None else orientation
    T[:3, 3] = numbers("--xyz", xyz, XYZ)
    return T


def positions(option: str, text: str, robot: Robot, group: JointGroup | None = None, *, degrees: bool) -> Array:
    """The q [rad or m], shape (n_dof,), of an option: numbers, a state of the SRDF, or ``home``.

    Raises:
        InputError: They are not the numbers of one q.
        UnknownNameError: There is no such state.
    """
    state = state_of(text, robot, group)
    if state is not None:
        return robot.named_configurations[state]
    return robot.home if text == HOME else np.array(numbers(option, text, coordinates_of(robot), degrees=degrees))


def state_of(text: str, robot: Robot, group: JointGroup | None) -> str | None:
    """The key of the state of the SRDF that a text names; None if the text is ``home`` or numbers.

    Raises:
        UnknownNameError: It is another name.
    """
    try:
        return state_named(text, robot.srdf.states, group).key
    except UnknownNameError:
        if is_name(text) and text != HOME:
            raise
    return None
