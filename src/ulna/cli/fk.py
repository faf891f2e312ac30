"""``ulna fk``: the pose of a link."""

from collections.abc import Iterator, Sequence
from math import degrees as in_degrees

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType

from ulna.cli.depends import as_options, command
from ulna.cli.options import AnyRobot, Link
from ulna.cli.output import Q_KEYS, Output, data_of_q, make_table, number, title
from ulna.cli.targets import ControllerName, Q, StatedIn
from ulna.description.controllers import Controller, controller_named, pose_as
from ulna.description.pose import quaternion_from_matrix, rpy_from_matrix

FK_KEYS = (
    f"{Q_KEYS}; base; link; frame: that of the pose, by default the base; position; rpy; wxyz; matrix: 4x4; controller: its "
    "name, labels, units and numbers, or null."
)


@command
def fk(robot: AnyRobot, link: Link, q: Q, frame: StatedIn, *, controller: ControllerName = None) -> Output:
    """Forward kinematics: print the pose of a link.

    Example: ulna fk --q "0,-pi/4,0,-3pi/4,0,pi/2,pi/4", or ulna fk --controller KUKA for the numbers on its pendant.
    """
    with as_options({"frame": "--frame"}):
        T_base_link = robot.forward_kinematics(q, link=link, frame=frame)
    said = None if controller is None else controller_named(controller, "--controller")
    data = {
        **data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "frame": robot.base if frame is None else frame,
        "position": T_base_link[:3, 3],
        "rpy": rpy_from_matrix(T_base_link),
        "wxyz": quaternion_from_matrix(T_base_link),
        "matrix": T_base_link,
        "controller": None if said is None else _stated(T_base_link, said),
    }
    return Output(data, fk_table)


def _stated(T_base_link: NDArray[np.float64], said: Controller) -> dict[str, object]:
    """State a pose in the controller's convention."""
    return {"name": said.name, "labels": said.labels, "units": said.units, "numbers": pose_as(T_base_link, said.name)}


def fk_table(data) -> Iterator[RenderableType]:
    """Show position, orientation as roll, pitch, yaw and as a quaternion, and the matrix."""
    frame = data["frame"] if isinstance(data["frame"], str) else "the frame"
    yield title(data, f"{data['link']} in {frame}")
    table = make_table([""], [""] * 4, [""])
    table.show_header = False
    table.add_row("position x, y, z", *_four(data["position"]), "m")
    table.add_row("roll, pitch, yaw", *_four(data["rpy"]), "rad")
    table.add_row("", *_four([in_degrees(angle) for angle in data["rpy"]]), "deg")
    table.add_row("quaternion w, x, y, z", *_four(data["wxyz"]), "", end_section=True)
    for k, row in enumerate(data["matrix"]):
        table.add_row("" if k else "matrix", *_four(row), "")
    yield table
    if said := data["controller"]:
        words = (f"{label} {value:.4f}" for label, value in zip(said["labels"], said["numbers"], strict=True))
        yield f"{said['name']} [{said['units']}]: {', '.join(words)}"


def _four(values: Sequence[float]) -> list[str]:
    """Format numbers as four cells; missing ones are empty."""
    return [number(value) for value in values] + [""] * (4 - len(values))
