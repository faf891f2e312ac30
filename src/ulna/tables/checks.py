"""``ulna demo --check`` for people and programs."""

from collections.abc import Iterable
from dataclasses import asdict

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from ulna.checks import Check
from ulna.tables.writing import make_console, show, write


def show_checks(checks: Iterable[Check], *, as_json: bool) -> bool:
    """Print the checks, each as soon as it has run: rows on a terminal, plain lines elsewhere. Whether all passed."""
    console, done = make_console(), []
    if console.is_terminal and not as_json:
        console.print(_check_row(Text("verdict"), "check", "figure", "bound", style="bold"))
    for check in checks:
        done.append(check)
        verdict = Text("passed", "green") if check.passed else Text("FAILED", "bold red")
        if console.is_terminal and not as_json:
            console.print(_check_row(verdict, check.name, check.figure, check.bound))
        elif not as_json:
            write(f"{verdict}  {check.name}: {check.figure}; bound: {check.bound}\n")
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
