"""``ulna fk``: the pose of a link."""

from collections.abc import Iterator, Sequence
from math import degrees as in_degrees

from rich.console import RenderableType

from ulna.cli.depends import command
from ulna.cli.options import AnyRobot, Link
from ulna.cli.output import Q_KEYS, Output, data_of_q, make_table, number, title
from ulna.cli.targets import Q
from ulna.description.pose import quaternion_from_matrix, rpy_from_matrix

FK_KEYS = f"{Q_KEYS}; base; link; position; rpy; wxyz; matrix: 4x4, T_base_link."


@command
def fk(robot: AnyRobot, q: Q, link: Link) -> Output:
    """Forward kinematics: the pose of a link.

    As in: ulna fk --q "0,-pi/4,0,-3pi/4,0,pi/2,pi/4".
    """
    T_base_link = robot.forward_kinematics(q, link=link)
    data = {
        **data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "position": T_base_link[:3, 3],
        "rpy": rpy_from_matrix(T_base_link),
        "wxyz": quaternion_from_matrix(T_base_link),
        "matrix": T_base_link,
    }
    return Output(data, fk_table)


def fk_table(data) -> Iterator[RenderableType]:
    """Position, orientation as roll, pitch, yaw and as a quaternion, and the matrix."""
    yield title(data, f"{data['link']} in {data['base']}")
    table = make_table([""], [""] * 4, [""])
    table.show_header = False
    table.add_row("position x, y, z", *_four(data["position"]), "m")
    table.add_row("roll, pitch, yaw", *_four(data["rpy"]), "rad")
    table.add_row("", *_four([in_degrees(angle) for angle in data["rpy"]]), "deg")
    table.add_row("quaternion w, x, y, z", *_four(data["wxyz"]), "", end_section=True)
    for k, row in enumerate(data["matrix"]):
        table.add_row("" if k else "matrix", *_four(row), "")
    yield table


def _four(values: Sequence[float]) -> list[str]:
    """Numbers as four cells, the last of which may be empty."""
    return [number(value) for value in values] + [""] * (4 - len(values))
