"""``ulna dh``: the Denavit-Hartenberg table of a chain."""

from typing import Annotated

import typer

from ulna.answers.dh import dh_data
from ulna.commands.options import Json, Link, PackageDirs, RobotName, XacroArgs, load_robot
from ulna.model.dh_table import PARALLEL
from ulna.tables.dh import dh_view
from ulna.tables.writing import show


def dh(
    robot: RobotName = "panda",
    *,
    link: Link = None,
    convention: Annotated[str, typer.Option(metavar="NAME", help="modified (Craig) or standard.")] = "modified",
    tolerance: Annotated[float, typer.Option(metavar="RAD", help="Axes within this angle count as parallel.")] = PARALLEL,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """The Denavit-Hartenberg table from the base to a link, and the proof that it is the same robot.

    Fixed joints go into the poses of frame 0 and of the tip.
    """
    table = load_robot(robot, xacro_arg, package_dir).dh(convention, link, tolerance=tolerance)
    show(dh_data(table), None if as_json else dh_view)
