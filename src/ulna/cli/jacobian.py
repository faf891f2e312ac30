"""``ulna jacobian``: the Jacobian of a link."""

from collections.abc import Iterator
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import command
from ulna.cli.options import AnyRobot, Link
from ulna.cli.output import Q_KEYS, Output, data_of_q, folded, make_table, number, title
from ulna.cli.targets import Q
from ulna.errors import InputError
from ulna.robot.coordinates import coordinates_of

Frame = Annotated[str | None, typer.Option(metavar="FRAME", help="base, link or spatial; by default base.")]
Analytical = Annotated[bool, typer.Option("--analytical", help="Rates of x, y, z, roll, pitch, yaw instead.")]

JACOBIAN_KEYS = (
    f"{Q_KEYS}; base; link; kind: geometric or analytical; expressed_in: base, link or spatial, null if analytical; "
    "rows and columns: their labels; jacobian: 6 rows."
)
GEOMETRIC_ROWS = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
ANALYTICAL_ROWS = ("x", "y", "z", "roll", "pitch", "yaw")
COLUMNS_AT_ONCE = 7  # the number that fits into 80 characters


@command
def jacobian(robot: AnyRobot, q: Q, link: Link, *, expressed_in: Frame = None, analytical: Analytical = False) -> Output:
    """Print the Jacobian: the velocity of a link for a unit rate of each joint.

    Rows are linear first, then angular: meters and radians per second.
    """
    if analytical and expressed_in is not None:
        raise InputError("--expressed-in", "applies to the geometric Jacobian, not to --analytical")
    frame = None if analytical else "base" if expressed_in is None else expressed_in
    J = robot.analytical_jacobian(q, link=link) if frame is None else robot.jacobian(q, link=link, expressed_in=frame)
    data = {
        **data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "kind": "analytical" if frame is None else "geometric",
        "expressed_in": frame,
        "rows": ANALYTICAL_ROWS if frame is None else GEOMETRIC_ROWS,
        "columns": [entry.name for entry in coordinates_of(robot)],
        "jacobian": J,
    }
    return Output(data, jacobian_table)


def jacobian_table(data) -> Iterator[RenderableType]:
    """Show the matrix, a few columns at a time."""
    frame = f", expressed in {data['expressed_in']}" if data["expressed_in"] else f", rates in {data['base']}"
    yield title(data, f"{data['kind']} Jacobian of {data['link']}{frame}")
    for first in range(0, max(len(data["columns"]), 1), COLUMNS_AT_ONCE):
        some = slice(first, first + COLUMNS_AT_ONCE)
        table = make_table([], ["", *(folded(name) for name in data["columns"][some])], [])
        for label, row in zip(data["rows"], data["jacobian"], strict=True):
            table.add_row(Text(label, "bold"), *(number(value, 5) for value in row[some]))
        yield table
