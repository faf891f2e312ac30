"""What people see of an answer: ``..._view`` draws the dictionary that ``answers`` made, so that tables and JSON say the same."""

import json
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from math import degrees

import numpy as np
import typer
from numpy.typing import NDArray
from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from ulna.answers import Data, plain
from ulna.checks import Check
from ulna.model.pose import rpy_from_matrix

Array = NDArray[np.float64]

LEAST_WIDTH = 80
COLUMNS_AT_ONCE = 7  # of a Jacobian: as many as fit into that
NUMBER_WIDTH = 8
TRACK_WIDTH = 13
ASCII = str.maketrans("─●", "-o")

# ---- the robot --------------------------------------------------------------------------------------------------------


def info_view(data) -> Iterator[RenderableType]:
    """The robot's names, its joints, its links and its collision shapes."""
    tip = data["tip"] or f"{len(data['leaves'])} tips"
    yield Text.assemble((data["name"], "bold"), f": {data['n_dof']} dof, {data['base']} to {tip}")
    table = _table(["joint", "type"], ["lower", "upper", "home", "unit", "velocity\nlimit", "unit"], [])
    for joint in data["joints"]:
        lower, upper, home, velocity = (_short(joint[key]) for key in ("lower", "upper", "home", "velocity_limit"))
        table.add_row(joint["name"], joint["type"], lower, upper, home, joint["unit"], velocity, f"{joint['unit']}/s")
    yield table
    for mimic in data["mimic_joints"]:
        yield f"{mimic['name']} = {mimic['multiplier']:g} * {mimic['joint']} + {mimic['offset']:g}"
    yield _names("fixed joints", data["fixed_joints"])
    yield _names("links", data["links"])
    shapes = _table(["collision shape", "link", "kind"], [], ["extents [m]"])
    for shape in data["collision_shapes"]:
        shapes.add_row(shape["name"], shape["link"], shape["kind"], _measures(shape))
    yield shapes if data["collision_shapes"] else "no collision shapes: ulna check has nothing to check"


def _names(kind: str, names: Sequence[str]) -> Text:
    return Text.assemble((f"{kind} ({len(names)})", "bold"), ": " * bool(names), ", ".join(names))


def _measures(shape) -> str:
    if "extents" in shape:
        return " x ".join(f"{extent:g}" for extent in shape["extents"])
    rest = {key: value for key, value in shape.items() if key not in ("name", "link", "kind")}
    if shape["kind"] == "mesh":
        return f"{rest['uri']}, scale {' '.join(f'{s:g}' for s in rest['scale'])}"
    return ", ".join(f"{key} {value:g}" for key, value in rest.items())


# ---- kinematics -------------------------------------------------------------------------------------------------------


def _title(data, text: str) -> Text:
    """What is shown, at which q, and a warning if the robot cannot stand there."""
    q = ", ".join(f"{value:.6g}" for value in data["q"])
    outside = f"\nq is beyond the limits of {', '.join(data['outside_limits'])}" if data["outside_limits"] else ""
    return Text.assemble((f"{data['robot']}: {text}", "bold"), f"\nq = {q}", (outside, "yellow"))


def pose_view(data) -> Iterator[RenderableType]:
    """Position, both ways to write the orientation, and the matrix."""
    yield _title(data, f"{data['link']} in {data['base']}")
    table = _table([""], [""] * 4, [""])
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
    yield _title(data, f"{data['kind']} Jacobian of {data['link']}{frame}")
    for first in range(0, max(len(data["columns"]), 1), COLUMNS_AT_ONCE):
        some = slice(first, first + COLUMNS_AT_ONCE)
        table = _table([], ["", *(_folded(name) for name in data["columns"][some])], [])
        for label, row in zip(data["rows"], data["jacobian"], strict=True):
            table.add_row(Text(label, "bold"), *(_number(value, 5) for value in row[some]))
        yield table


def ik_view(data) -> Iterator[RenderableType]:
    """The target, the verdict, and q between its limits."""
    T = np.array(data["target"]["matrix"])
    turn = ", ".join(_number(angle) for angle in rpy_from_matrix(T)) + " rad"
    yield Text.assemble(
        (f"{data['robot']}: {data['link']} in {data['base']}", "bold"),
        f"\nposition x, y, z  {', '.join(_number(x) for x in T[:3, 3])} m",
        f"\nroll, pitch, yaw  {turn}",
        " (none given: as at home)" if data["target"]["orientation"] == "home" else "",
    )
    table = _table(["joint"], ["q", "", "deg", "lower", "upper"], ["within its limits"])
    for name, unit, q, *limits in zip(*(data[key] for key in ("joints", "units", "q", "lower", "upper")), strict=True):
        in_degrees = _number(degrees(q), 2) if unit == "rad" else ""
        table.add_row(name, _number(q), unit, in_degrees, *map(_short, limits), _track(q, *limits))
    yield table
    steps = f"{data['iterations']} step{'s' * (data['iterations'] != 1)}"
    off = ["inf" if data[key] is None else f"{data[key]:.2g}" for key in ("position_error", "rotation_error")]
    yield Text.assemble(
        (data["status"], "bold green" if data["success"] else "bold red"),
        f": {off[0]} m and {off[1]} rad from the target after {steps}",
    )


# ---- collision and the checks -----------------------------------------------------------------------------------------


def report_view(data) -> Iterator[RenderableType]:
    """The verdict, the pairs, deepest first, and the least distance."""
    yield _title(data, "collision check")
    if data["pairs"]:
        table = _table(["robot", "link", "other"], ["apart [mm]"], ["normal", "at [m]"])
        for pair in data["pairs"]:
            vectors = [" ".join(_number(x, n) for x in pair[key]) for key, n in (("normal", 2), ("witness_a", 3))]
            table.add_row(pair["name_a"], pair["link"], pair["name_b"], f"{1000 * pair['signed_distance'] + 0.0:.3f}", *vectors)
        yield table
    if data["signed_distance"] is not None:
        yield f"least distance: {1000 * data['signed_distance'] + 0.0:.3f} mm"
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")


def show_checks(checks: Iterable[Check], *, as_json: bool) -> bool:
    """Print the checks, each as soon as it has run: rows on a terminal, plain lines elsewhere. Whether all passed."""
    console, done = _console(), []
    if console.is_terminal and not as_json:
        console.print(_check_row(Text("verdict"), "check", "figure", "bound", style="bold"))
    for check in checks:
        done.append(check)
        verdict = Text("passed", "green") if check.passed else Text("FAILED", "bold red")
        if console.is_terminal and not as_json:
            console.print(_check_row(verdict, check.name, check.figure, check.bound))
        elif not as_json:
            _write(f"{verdict}  {check.name}: {check.figure}; bound: {check.bound}\n")
    passed = all(check.passed for check in done)
    if as_json:
        show({"passed": passed, "checks": [asdict(check) for check in done]}, None)
    return passed


def _check_row(*cells: RenderableType, style: str = "") -> Table:
    """One row of the checks: a table of its own, of the same widths as the others."""
    row = Table.grid(expand=True, padding=(0, 2, 0, 0))
    row.add_column(width=len("verdict"))
    for ratio in (5, 6, 3):
        row.add_column(ratio=ratio)
    row.add_row(*cells, style=style)
    return row


# ---- how it is written ------------------------------------------------------------------------------------------------


def show(data: Data, view) -> None:
    """Print an answer: drawn by ``view``, or without one as JSON."""
    if view is None:
        _write(json.dumps(plain(data), allow_nan=False) + "\n")
        return
    console, drawn = _console(), list(view(plain(data)))
    unbounded = console.options.update(width=1_000_000)
    console.width = max(console.width, *(console.measure(part, options=unbounded).minimum for part in drawn))  # cut no digit
    with console.capture() as capture:
        console.print(*drawn, sep="\n")
    text = "\n".join(line.rstrip() for line in capture.get().split("\n"))
    _write(text.translate(ASCII) if console.options.ascii_only else text)


def _console() -> Console:
    console = Console(markup=False, emoji=False, highlight=False)
    console.width = max(console.width, LEAST_WIDTH)
    return console


def _write(text: str) -> None:
    typer.echo(text, nl=False, color=True)  # the console has chosen the colours already


def _table(names: Sequence[str], numbers: Sequence[str], ends: Sequence[str]) -> Table:
    """A table of columns of names, then of numbers, then of what follows them; names are folded, numbers never cut."""
    table = Table(box=box.SIMPLE, header_style="bold", collapse_padding=True, pad_edge=False)
    for header in names:
        table.add_column(header, overflow="fold")
    for header in numbers:
        table.add_column(header, justify="right", no_wrap=True)
    for header in ends:
        table.add_column(header, overflow="fold")
    return table


def _folded(name: str) -> str:
    """A name in lines no wider than a number, broken behind underscores and points."""
    pieces = name.replace("_", "_ ").replace(".", ". ")
    return "\n".join(line.replace("_ ", "_").replace(". ", ".") for line in textwrap.wrap(pieces, NUMBER_WIDTH))


def _pad(values: Sequence[float], count: int = 4) -> list[str]:
    return [_number(value) for value in values] + [""] * (count - len(values))


def _number(value: float, digits: int = 6) -> str:
    if abs(value) >= 1e7:
        return f"{value:.6g}"
    return f"{round(value, digits) + 0.0:.{digits}f}"  # + 0.0: no "-0.000000"


def _short(value: float | None) -> str:
    return "none" if value is None else _number(value, 4)


def _track(value: float, lower: float | None, upper: float | None) -> str:
    """Where a number lies between its limits, drawn."""
    if lower is None or upper is None or upper <= lower:
        return ""
    place = round((value - lower) / (upper - lower) * (TRACK_WIDTH - 1))
    return "─" * place + "●" + "─" * (TRACK_WIDTH - 1 - place)
