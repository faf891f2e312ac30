"""What people see of an answer, as tables, and the same as plain data for ``--json``.

Each kind of answer has two functions: ``..._data`` puts it into a dictionary and ``..._view`` draws that dictionary, so that
both say the same. ``..._KEYS`` says what the keys mean; ``--help`` shows it. Metres and radians throughout.
"""

import json
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from math import degrees
from typing import NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from ulna.checks import Check
from ulna.collision.report import Report
from ulna.ik.result import IKResult
from ulna.model.description import JointType
from ulna.model.pose import quaternion_from_matrix, rpy_from_matrix
from ulna.robot import Robot

Array = NDArray[np.float64]
Data = dict[str, object]

LEAST_WIDTH = 80
COLUMNS_AT_ONCE = 7  # of a Jacobian: as many as fit into that
NUMBER_WIDTH = 8
TRACK_WIDTH = 13
GEOMETRIC_ROWS = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
ANALYTICAL_ROWS = ("x", "y", "z", "roll", "pitch", "yaw")
ASCII = str.maketrans("─●", "-o")

INFO_KEYS = (
    "name; base; tip (null if there are several); leaves; n_dof; joints: one for each entry of q, with name, type, lower, upper, "
    "velocity_limit, home, unit; fixed_joints; mimic_joints: name, joint, multiplier, offset; links; collision_shapes: name, link, "
    "kind, and extents, or radius and length, or uri and scale."
)
_Q_KEYS = "robot; q; outside_limits: joints of q beyond their limits"
POSE_KEYS = f"{_Q_KEYS}; base; link; position; rpy; wxyz; matrix: 4x4, T_base_link."
JACOBIAN_KEYS = (
    f"{_Q_KEYS}; base; link; kind: geometric or analytical; expressed_in: null if analytical; rows, columns: labels; jacobian."
)
IK_KEYS = (
    "robot; base; link; target: matrix, 4x4, and orientation, given or home; method; status; success; joints; units; q; lower; "
    "upper; position_error; rotation_error; iterations."
)
REPORT_KEYS = (
    f"{_Q_KEYS}; in_collision; touching: shapes of the robot; pairs: name_a of the robot, name_b of the world, link, "
    "signed_distance (negative: overlap), normal from a to b."
)
CHECKS_KEYS = "passed; checks: name, figure, bound, passed."


class Entry(NamedTuple):
    """One entry of q, or of another list of numbers that people write: its name and its unit."""

    name: str
    unit: str
    type: str = ""


_PARTS = {
    JointType.PRISMATIC: (("", "m"),),
    JointType.PLANAR: ((".x", "m"), (".y", "m"), (".theta", "rad")),
    JointType.FLOATING: ((".x", "m"), (".y", "m"), (".z", "m"), (".roll", "rad"), (".pitch", "rad"), (".yaw", "rad")),
}


def entries_of_q(robot: Robot) -> list[Entry]:
    """What each entry of q is, in order."""
    types = {joint.name: joint.type for joint in robot.description.joints}
    return [
        Entry(name + part, unit, types[name].value)
        for name in robot.joint_names
        for part, unit in _PARTS.get(types[name], (("", "rad"),))
    ]


# ---- the robot --------------------------------------------------------------------------------------------------------


def info_data(robot: Robot) -> Data:
    """What a robot is; see ``INFO_KEYS``."""
    joints = robot.description.joints
    numbers = zip(robot.lower, robot.upper, robot.velocity_limits, robot.home, strict=True)
    keys = ("lower", "upper", "velocity_limit", "home")
    return {
        "name": robot.name,
        "base": robot.base,
        "tip": robot.tip,
        "leaves": list(robot.tree.leaves),
        "n_dof": robot.n_dof,
        "joints": [
            {"name": entry.name, "type": entry.type, **dict(zip(keys, row, strict=True)), "unit": entry.unit}
            for entry, row in zip(entries_of_q(robot), numbers, strict=True)
        ],
        "fixed_joints": [j.name for j in joints if j.type == JointType.FIXED],
        "mimic_joints": [{"name": j.name, **asdict(j.mimic)} for j in joints if j.mimic is not None],
        "links": list(robot.link_names),
        "collision_shapes": [
            {"name": body.name, "link": link.name, "kind": type(body.shape).__name__.lower(), **asdict(body.shape)}
            for link in robot.description.links
            for body in link.collisions
        ],
    }


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


def _data_of_q(robot: Robot, q: Array) -> Data:
    outside = (q < robot.lower) | (q > robot.upper)
    names = [entry.name for entry, out in zip(entries_of_q(robot), outside, strict=True) if out]
    return {"robot": robot.name, "q": q, "outside_limits": names}


def _title(data, text: str) -> Text:
    """What is shown, at which q, and a warning if the robot cannot stand there."""
    q = ", ".join(f"{value:.6g}" for value in data["q"])
    outside = f"\nq is beyond the limits of {', '.join(data['outside_limits'])}" if data["outside_limits"] else ""
    return Text.assemble((f"{data['robot']}: {text}", "bold"), f"\nq = {q}", (outside, "yellow"))


def pose_data(robot: Robot, q: Array, link: str, T: Array) -> Data:
    """The pose of a link; see ``POSE_KEYS``."""
    return {
        **_data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "position": T[:3, 3],
        "rpy": rpy_from_matrix(T),
        "wxyz": quaternion_from_matrix(T),
        "matrix": T,
    }


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


def jacobian_data(robot: Robot, q: Array, link: str, J: Array, expressed_in: str | None) -> Data:
    """A Jacobian with its labels; see ``JACOBIAN_KEYS``. ``expressed_in`` is None for the analytical one."""
    return {
        **_data_of_q(robot, q),
        "base": robot.base,
        "link": link,
        "kind": "analytical" if expressed_in is None else "geometric",
        "expressed_in": expressed_in,
        "rows": ANALYTICAL_ROWS if expressed_in is None else GEOMETRIC_ROWS,
        "columns": [entry.name for entry in entries_of_q(robot)],
        "jacobian": J,
    }


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


def ik_data(robot: Robot, link: str, T: Array, orientation: str, method: str, result: IKResult) -> Data:
    """What a search found; see ``IK_KEYS``."""
    return {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "target": {"matrix": T, "orientation": orientation},
        "method": method,
        "status": str(result.status),
        "success": bool(result.success),
        "joints": [entry.name for entry in entries_of_q(robot)],
        "units": [entry.unit for entry in entries_of_q(robot)],
        "q": result.q,
        "lower": robot.lower,
        "upper": robot.upper,
        "position_error": float(result.position_error),
        "rotation_error": float(result.rotation_error),
        "iterations": int(result.iterations),
    }


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


def report_data(robot: Robot, q: Array, report: Report) -> Data:
    """What a collision check found; see ``REPORT_KEYS``."""
    pairs = [{field.name: getattr(pair, field.name) for field in fields(pair)} for pair in report.pairs]
    return {**_data_of_q(robot, q), "in_collision": report.in_collision, "touching": report.touching, "pairs": pairs}


def report_view(data) -> Iterator[RenderableType]:
    """The verdict, and the pairs, deepest first."""
    yield _title(data, "collision check")
    if data["pairs"]:
        table = _table(["robot", "link", "world"], ["depth [mm]", "normal x", "y", "z"], [])
        for pair in data["pairs"]:
            depth = f"{-1000 * pair['signed_distance'] + 0.0:.3f}"
            table.add_row(pair["name_a"], pair["link"], pair["name_b"], depth, *(_number(n, 3) for n in pair["normal"]))
        yield table
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
    console.width = max(console.width, *(console.measure(part).minimum for part in drawn))  # longer lines, but no digit cut
    with console.capture() as capture:
        console.print(*drawn, sep="\n")
    text = "\n".join(line.rstrip() for line in capture.get().split("\n"))
    _write(text.translate(ASCII) if console.options.ascii_only else text)


def plain(value):
    """Dictionaries, lists, strings and numbers as JSON has them; what is infinite becomes None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


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
