"""``ulna fk``, ``ulna jacobian`` and ``ulna ik`` for people."""

from collections.abc import Iterator, Sequence
from math import degrees

import numpy as np
from rich.console import RenderableType
from rich.text import Text

from ulna.model.pose import rpy_from_matrix
from ulna.tables.writing import folded, make_table, number, short, title

COLUMNS_AT_ONCE = 7  # of a Jacobian: as many as fit into 80 columns
TRACK_WIDTH = 13


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


def jacobian_view(data) -> Iterator[RenderableType]:
    """The matrix, a few columns at a time."""
    frame = f", expressed in {data['expressed_in']}" if data["expressed_in"] else f", rates in {data['base']}"
    yield title(data, f"{data['kind']} Jacobian of {data['link']}{frame}")
    for first in range(0, max(len(data["columns"]), 1), COLUMNS_AT_ONCE):
        some = slice(first, first + COLUMNS_AT_ONCE)
        table = make_table([], ["", *(folded(name) for name in data["columns"][some])], [])
        for label, row in zip(data["rows"], data["jacobian"], strict=True):
            table.add_row(Text(label, "bold"), *(number(value, 5) for value in row[some]))
        yield table


def ik_view(data) -> Iterator[RenderableType]:
    """The target, the verdict, and q between its limits."""
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
        in_degrees = number(degrees(q), 2) if unit == "rad" else ""
        table.add_row(name, number(q), unit, in_degrees, *map(short, limits), _track(q, *limits))
    yield table
    if data["trace"] is not None:
        yield _trace_table(data["trace"])
    steps = f"{data['iterations']} step{'s' * (data['iterations'] != 1)}"
    off = ["inf" if data[key] is None else f"{data[key]:.2g}" for key in ("position_error", "rotation_error")]
    yield Text.assemble(
        (data["status"], "bold green" if data["success"] else "bold red"),
        f": {off[0]} m and {off[1]} rad from the target after {steps}",
        f"\n{data['reason']}" if data["reason"] else "",
    )


def _trace_table(trace) -> RenderableType:
    """A row a step."""
    table = make_table([], ["step", "position\nerror [m]", "rotation\nerror [rad]", "largest\njoint step", "damping"], [])
    for k, row in enumerate(trace):
        table.add_row(str(k), *(f"{value:.3g}" for value in row))
    return table


def _pad(values: Sequence[float], count: int = 4) -> list[str]:
    return [number(value) for value in values] + [""] * (count - len(values))


def _track(value: float, lower: float | None, upper: float | None) -> str:
    """Where a number lies between its limits, drawn."""
    if lower is None or upper is None or upper <= lower:
        return ""
    place = round((value - lower) / (upper - lower) * (TRACK_WIDTH - 1))
    return "─" * place + "●" + "─" * (TRACK_WIDTH - 1 - place)
