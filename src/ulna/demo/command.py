"""``ulna demo``: the assignment's checks, and its page."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from ulna.cli.depends import Json, command
from ulna.cli.options import OnPage, PageOptions
from ulna.cli.output import make_console, write, write_json
from ulna.demo.checks import Check, run_checks
from ulna.demo.ros.command import ros1, ros2
from ulna.demo.scenario import Demo
from ulna.errors import InputError, needs_extra

ChecksOnly = Annotated[bool, typer.Option("--check", help="Stop after the checks.")]

DEMO_KEYS = "passed; checks: name, figure, bound, passed."


@command
def demo(page: OnPage, *, check: ChecksOnly = False, as_json: Json = False) -> None:
    """Show the assignment's arm, box and light in the browser, and run its checks on this machine.

    Exit status 1 if a check fails; then the page ends.
    """
    if as_json and not check:
        raise InputError("--json", "requires --check; the page has no JSON output")
    if check and page != PageOptions():
        raise InputError("--host, --port, --no-open", "apply to the page, which --check does not open")
    if not (show_checks(run_checks(), as_json=as_json) if check else _serve(page)):
        raise typer.Exit(1)


def _serve(page: PageOptions) -> bool:
    """Serve the page, and run the checks while it is open. Returns whether all passed."""
    with needs_extra("the view", "viewer", "viser", "trimesh", "av", "PIL"):
        from ulna.demo.page import serve  # noqa: PLC0415 -- the one layer that needs the extra
    return serve(Demo(), **page._asdict(), meanwhile=lambda: show_checks(run_checks(), as_json=False))


def show_checks(checks: Iterable[Check], *, as_json: bool) -> bool:
    """Print each check as soon as it has run: rows on a terminal, plain lines elsewhere. Returns whether all passed."""
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
        write_json({"passed": passed, "checks": [asdict(check) for check in done]})
    return passed


def _check_row(*cells: RenderableType, style: str = "") -> Table:
    """Make one row of the checks: a table of its own with the same widths as the others."""
    row = Table.grid(expand=True, padding=(0, 2, 0, 0))
    row.add_column(width=len("verdict"))
    for ratio in (5, 6, 3):
        row.add_column(ratio=ratio)
    row.add_row(*cells, style=style)
    return row


commands = typer.Typer()
commands.command(epilog=f"JSON: {DEMO_KEYS}", rich_help_panel="Look")(demo)
commands.add_typer(ros1, name="ros1", rich_help_panel="ROS")
commands.add_typer(ros2, name="ros2", rich_help_panel="ROS")
