"""``ulna fk``: where a link is."""

from collections.abc import Iterator, Sequence
from math import degrees

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType

from ulna.cli.data import Q_KEYS, Data, data_of_q
from ulna.cli.options import Degrees, Json, Link, PackageDirs, Positions, RobotName, XacroArgs, load_robot, positions
from ulna.cli.output import make_table, number, show, title
from ulna.description.pose import quaternion_from_matrix, rpy_from_matrix
from ulna.robot import Robot

Array = NDArray[np.float64]
POSE_KEYS = f"{Q_KEYS}; base; link; position; rpy; wxyz; matrix: 4x4, T_base_link."


def pose_data(robot: Robot, q: Array, link: str, T: Array) -> Data:
    """The pose of a link; see ``POSE_KEYS``."""
    return {
        **data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "position": T[:3, 3],
        "rpy": rpy_from_matrix(T),
        "wxyz": quaternion_from_matrix(T),
        "matrix": T,
    }


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


def pose_view(data) -> Iterator[RenderableType]:
    """Position, both ways to write the orientation, and the matrix."""
    yield title(data, f"{data['link']} in {data['base']}")
    table = make_table([""], [""] * 4, [""])
    table.show_header = False
    table.add_row("position x, y, z", *_pad(data["position"]), "m")
    table.add_row("roll, pitch, yaw", *_pad(data["rpy"]), "rad")
    table.add_row("", *_pad([degrees(angle) for angle in data["rpy"]]), "deg")
    table.add_row("quaternion w, x, y, z", *_pad(data["wxyz"]), "", end_section=True)
    for k, row in enumerate(data["matrix"]):
        table.add_row("" if k else "matrix", *_pad(row), "")
    yield table


def _pad(values: Sequence[float], count: int = 4) -> list[str]:
    return [number(value) for value in values] + [""] * (count - len(values))
