"""``ulna bench``: measures Ulna's speed on this machine."""

from collections.abc import Iterator
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from ulna.bench.arms import NAMES
from ulna.bench.report import SUBJECTS, measure
from ulna.cli.depends import command
from ulna.cli.output import Output, make_table

Subjects = Annotated[
    list[str] | None, typer.Argument(metavar="SUBJECT...", help=f"{', '.join(SUBJECTS)}; by default all of them.")
]
Robots = Annotated[list[str] | None, typer.Option(metavar="ROBOT", help=f"{', '.join(NAMES)}, or a file; repeatable.")]
Targets = Annotated[int, typer.Option("--n", min=1, help="Targets of each protocol of inverse kinematics.")]

BENCH_KEYS = (
    "machine; fk, jacobian, ik, collision: robot, work, median_ns, lower_ns and upper_ns (quartiles) of one problem, per_second; "
    "protocols; tracking; left_out: what was not measured, and why. Each is a list of rows."
)


@command
def bench(subjects: Subjects = None, *, robot: Robots = None, n: Targets = 1000) -> Output:
    """Time Ulna on this machine: medians and quartiles of calls and batches, and success rates of inverse kinematics.

    Example: ulna bench ik --robot ur5 --robot jaco2 --n 10000. docs/performance_ik.md describes the protocols.
    """
    return Output(measure(subjects or (), robot or ("panda",), n), bench_table)


def bench_table(data) -> Iterator[RenderableType]:
    """Show the machine, and a table for each list of rows, with the keys as columns."""
    yield Text(", ".join(f"{key.replace('_', ' ')} {value}" for key, value in data["machine"].items()))
    for title, rows in data.items():
        if title != "machine" and rows:
            yield Text(title.replace("_", " "), "bold")
            yield _table_of(rows)


def _table_of(rows) -> Table:
    names = [key for key, value in rows[0].items() if isinstance(value, str)]
    table = make_table([_header(key) for key in names], [_header(key) for key in rows[0] if key not in names], [])
    for row in rows:
        table.add_row(*(row[key] for key in names), *(_figure(value) for key, value in row.items() if key not in names))
    return table


def _header(key: str) -> str:
    return key.replace("_", "\n")


def _figure(value: float) -> str:
    """Format a number with four digits, or with all of them if it is an integer or at least 1000."""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.0f}" if value >= 1000 else f"{value:.4g}"
