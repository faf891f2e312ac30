"""``ulna list``: the robots that have names."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import command
from ulna.cli.output import Output, make_table
from ulna.description.names.by_name import KnownRobot, known_robots, packages_to_install
from ulna.errors import count_of

Part = Annotated[str, typer.Argument(metavar="PART", help="A part of a name, of a maker or of a package; by default all robots.")]

LIST_KEYS = (
    "robots: name, also (its other names), package, path (null if bundled or not downloaded yet), installed, and of bundled ones "
    "maker, model, payload (kg), reach (m), else null; to_install: packages that add more robots."
)


@command
def list(part: Part = "") -> Output:  # noqa: A001 -- the command's name
    """List the robots that have names: maker, model, payload and reach, or the package that has them.

    Example: ulna list ur. Exit status 1 if no robot matches.
    """
    robots = [robot for robot in known_robots() if part.lower() in _words(robot)]
    data = {"robots": [asdict(robot) for robot in robots], "to_install": packages_to_install()}
    return Output(data, list_table, status=0 if robots else 1)


def _words(robot: KnownRobot) -> str:
    return " ".join((robot.name, *robot.also, robot.package, robot.maker or "", robot.model or "")).lower()


def list_table(data) -> Iterator[RenderableType]:
    """Show the arms that come with Ulna, the robots in packages, and the packages that add more."""
    bundled = make_table(["arm", "model"], ["kg", "m"], ["also called"])
    packaged = make_table(["robot", "also called", "package"], [], [""])
    for robot in data["robots"]:
        also = ", ".join(robot["also"])
        if robot["maker"] is not None:
            model = f"{robot['maker']} {robot['model']}"
            bundled.add_row(robot["name"], model, f"{robot['payload']:g}", f"{robot['reach']:g}", also)
        else:
            packaged.add_row(robot["name"], also, robot["package"], "" if robot["installed"] else "not downloaded")
    if bundled.row_count:
        yield bundled
        yield "kg: rated payload; m: reach"
    if packaged.row_count:
        yield packaged
    yield Text(count_of(len(data["robots"]), "robot") if data["robots"] else "no robot matches", "bold")
    if data["to_install"]:
        yield f"for more robots: pip install {' '.join(data['to_install'])}"
