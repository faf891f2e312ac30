"""``ulna view``: shows a robot on a page of this machine."""

from __future__ import annotations

import logging
import os
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING

import typer

from ulna.cli.cell import Obstacles, ShownRobot, warn_of_missing
from ulna.cli.depends import command
from ulna.cli.mount import FreeFall, mounted
from ulna.cli.options import OnPage
from ulna.cli.output import printable
from ulna.cli.targets import BeginningQ
from ulna.viewer.open_page import view as open_view

if TYPE_CHECKING:
    from ulna.viewer.view import View

_PATIENCE_S = 2.0


@command
def view(robot: ShownRobot, world: Obstacles, q: BeginningQ, page: OnPage, free_fall: FreeFall) -> None:
    """Show any robot in the browser: drag its hand, move its joints, add obstacles; see distances and contacts.

    Ctrl-C ends it.
    """
    serve(open_view(mounted(robot, free_fall), world, q=q, **page._asdict()))


def serve(shown: View) -> None:
    """Print the address of a page, and wait for Ctrl-C."""
    with suppress(KeyboardInterrupt):
        typer.echo(f"{printable(shown.session.robot.name)} is at {shown.url}  (Ctrl-C ends it)")
        warn_of_missing(shown.arm.missing)
        shown.wait()
    warnings.simplefilter("ignore")  # open pages cause warnings when the server stops
    logging.disable()
    if not shown.stop(within=_PATIENCE_S):
        os._exit(0)  # a long compilation is running; a normal exit during it would abort
