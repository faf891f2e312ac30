"""``ulna demo``: the assignment's checks, and its view."""

from typing import Annotated

import typer

from ulna.checks import run_checks
from ulna.commands.options import SERVED, Json, NoOpen, as_options
from ulna.demo import Demo
from ulna.errors import InputError, needs_extra
from ulna.tables.checks import show_checks


def demo(
    *,
    check: Annotated[bool, typer.Option("--check", help="Stop after the checks.")] = False,
    host: Annotated[str | None, typer.Option(help="Where to serve the view; 127.0.0.1 unless given.")] = None,
    port: Annotated[int | None, typer.Option(min=0, max=65535, help="Its port; 8080 unless given.")] = None,
    no_open: NoOpen = False,
    as_json: Json = False,
) -> None:
    """The assignment: its checks, run on this machine, and then the arm, the box and the light in the browser.

    Exit status 1 if a check fails; then nothing is served.
    """
    if as_json and not check:
        raise InputError("--json", "goes with --check; the view is no JSON")
    if check and (no_open or host is not None or port is not None):
        raise InputError("--host, --port, --no-open", "go with the view; --check stops before it")
    if not show_checks(run_checks(), as_json=as_json):
        raise typer.Exit(1)
    if not check:
        _serve("127.0.0.1" if host is None else host, 8080 if port is None else port, open_browser=not no_open)


def _serve(host: str, port: int, *, open_browser: bool) -> None:
    with needs_extra("the view", "viewer", "viser", "trimesh", "av", "PIL"):
        from ulna.viewer.app import serve  # noqa: PLC0415 -- the one layer that needs the extra
    with as_options(SERVED):
        serve(demo=Demo(), host=host, port=port, open_browser=open_browser)
