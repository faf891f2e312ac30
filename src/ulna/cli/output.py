"""Prints data as JSON, or as tables that truncate no number; writes figures."""

import json
import os
import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich import box
from rich.cells import cell_len
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from ulna.errors import FileError, InputError, reason_of
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Data = dict[str, object]
PlotFile = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw the joints: .png, .svg or .pdf.")]
TableOf = Callable[[Any], Iterable[RenderableType]]


class Output(NamedTuple):
    """Return value of a command: its data, the function that makes the table, and the exit status."""

    data: Data
    table: TableOf
    status: int = 0


Q_KEYS = "robot; q; outside_limits: joints of q beyond their limits"
# C0 and C1 controls and DEL, except tab and line feed; controls of the writing direction; lone surrogates.
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
MIN_WIDTH = 80  # characters of a line
NUMBER_WIDTH = 8
NAME_WIDTH = 12
ASCII = str.maketrans("─●│├└", "-o|+`")


def json_ready(value):
    """Convert a value to dictionaries, lists, strings and numbers; NaN and infinity, which JSON lacks, become None."""
    if isinstance(value, dict):
        return {key: json_ready(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return json_ready(value.tolist())
    if isinstance(value, list | tuple):
        return [json_ready(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def printable(value):
    """Escape control characters in data: a name from a file could otherwise control the terminal."""
    if isinstance(value, dict):
        return {printable(key): printable(item) for key, item in value.items()}
    if isinstance(value, list):
        return [printable(item) for item in value]
    return _CONTROLS.sub(lambda found: found[0].encode("unicode_escape").decode(), value) if isinstance(value, str) else value


def warn(text: str) -> None:
    """Print a line on standard error."""
    typer.echo(f"ulna: {printable(' '.join(text.split()))}", err=True)


def data_of_q(robot: Robot, q: NDArray[np.float64]) -> Data:
    """The robot's name, q, shape (n_dof,), and the joints beyond their limits; see ``Q_KEYS``."""
    outside = (q < robot.lower) | (q > robot.upper)
    names = [entry.name for entry, out in zip(coordinates_of(robot), outside, strict=True) if out]
    return {"robot": robot.name, "q": q, "outside_limits": names}


def attributes(thing: object, *names: str) -> Data:
    """The named attributes of an object, by name."""
    return {name: getattr(thing, name) for name in names}


def joint_columns(robot: Robot) -> Data:
    """The name and the unit of each entry of q."""
    entries = coordinates_of(robot)
    return {"joints": [entry.name for entry in entries], "units": [entry.unit for entry in entries]}


def show(output: Output, *, as_json: bool) -> None:
    """Print the data as one line of JSON, or as a table."""
    if as_json:
        write_json(output.data)
        return
    console = make_console()
    usual = console.width
    is_read = not console.is_terminal and "COLUMNS" not in os.environ  # a program reads the output; keep names whole
    with console.capture() as capture:
        for part in output.table(printable(json_ready(output.data))):
            console.width = max(usual, _least_width(console, part))
            console.print(part, soft_wrap=is_read and isinstance(part, str | Text))
    text = "\n".join(line.rstrip() for line in capture.get().split("\n"))
    write(text.translate(ASCII) if console.options.ascii_only else text)


def write_json(data: Data) -> None:
    """Print data as one line of JSON."""
    write(json.dumps(json_ready(data), allow_nan=False) + "\n")


def write(text: str) -> None:
    """Print text unchanged."""
    typer.echo(text, nl=False, color=True)  # the console has chosen the colors already


def make_console() -> Console:
    """Make a console that interprets no markup, as wide as the terminal and at least 80 columns."""
    console = Console(markup=False, emoji=False, highlight=False)
    console.width = max(console.width, MIN_WIDTH)
    return console


def write_figure(figure: Any, out: Path, argument: str = "plot") -> None:
    """Write a Matplotlib figure: .png, .svg or .pdf. ``argument`` names the path in an error."""
    try:
        figure.savefig(out, dpi=120)
    except ValueError as error:
        raise InputError(argument, str(error)) from None
    except OSError as error:
        raise FileError(str(out), reason_of(error, missing="no such folder")) from None


def title(data, text: str) -> Text:
    """The robot's name, a text, q, and a warning beyond the limits; ``data`` has the keys of ``data_of_q``."""
    q = ", ".join(f"{value:.6g}" for value in data["q"])
    outside = f"\nq is beyond the limits of {', '.join(data['outside_limits'])}" if data["outside_limits"] else ""
    return Text.assemble((f"{data['robot']}: {text}", "bold"), f"\nq = {q}", (outside, "yellow"))


def make_table(names: Sequence[str], numbers: Sequence[str], ends: Sequence[str]) -> Table:
    """Make a table with columns of names, then of numbers, then of other text; names wrap, numbers are never truncated."""
    table = Table(box=box.SIMPLE, header_style="bold", collapse_padding=True, pad_edge=False)
    for header in names:
        table.add_column(header, overflow="fold")
    for header in numbers:
        table.add_column(header, justify="right", no_wrap=True)
    for header in ends:
        table.add_column(header, overflow="fold")
    return table


def folded(name: str) -> str:
    """Wrap a name to the width of a number, after underscores and dots."""
    pieces = name.replace("_", "_ ").replace(".", ". ")
    return "\n".join(line.replace("_ ", "_").replace(". ", ".") for line in textwrap.wrap(pieces, NUMBER_WIDTH))


def number(value: float, digits: int = 6) -> str:
    """Format a number with a fixed count of decimals; from 1e7 on with six significant digits."""
    if abs(value) >= 1e7:
        return f"{value:.6g}"
    return f"{round(value, digits) + 0.0:.{digits}f}"  # + 0.0 avoids "-0.000000"


def limit(value: float | None) -> str:
    """Format a limit with four decimals, or as "none"."""
    return "none" if value is None else number(value, 4)


def _least_width(console: Console, part: RenderableType) -> int:
    """The minimum width without truncated numbers; names in tables wrap after ``NAME_WIDTH``."""
    if isinstance(part, Text) and part.no_wrap:
        return part.cell_len
    if not isinstance(part, Table):
        return console.measure(part, options=console.options.update(width=1_000_000)).minimum
    width = 0
    for column in part.columns:
        lines = [line for cell in (column.header, *column.cells) for line in str(cell).splitlines()]
        widest = max(map(cell_len, lines), default=0)
        width += 2 + (widest if column.no_wrap else min(widest, NAME_WIDTH))
    return width
