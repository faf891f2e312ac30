"""``ulna info`` and ``ulna urdf``: what a robot is."""

from typing import Annotated

import typer

from ulna.answers.robot import info_data
from ulna.commands.options import Json, PackageDirs, RobotName, XacroArgs, load_robot, xacro_arguments
from ulna.io.load import urdf_text
from ulna.tables.robot import info_view
from ulna.tables.writing import show


def info(
    robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None, as_json: Json = False
) -> None:
    """What a robot is: its joints with their limits, its links, its collision shapes."""
    show(info_data(load_robot(robot, xacro_arg, package_dir)), None if as_json else info_view)


def urdf(
    robot: RobotName = "panda",
    *,
    mesh_paths: Annotated[
        str, typer.Option(metavar="KIND", help="given: as they stand; file: absolute file:// addresses, as RViz needs.")
    ] = "given",
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
) -> None:
    """Print the robot's URDF: of a xacro file, what it expands to.

    It is printed even where it cannot be understood, so that an error's line can be looked up.
    """
    typer.echo(urdf_text(robot, xacro_arguments(xacro_arg), package_dir or (), mesh_paths).encode(), nl=False)
