"""``ulna info`` and ``ulna urdf``: what a robot is."""

import typer

from ulna.answers.robot import info_data
from ulna.commands.options import Json, PackageDirs, RobotName, XacroArgs, load_robot
from ulna.tables.robot import info_view
from ulna.tables.writing import show


def info(
    robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None, as_json: Json = False
) -> None:
    """What a robot is: its joints with their limits, its links, its collision shapes."""
    show(info_data(load_robot(robot, xacro_arg, package_dir)), None if as_json else info_view)


def urdf(robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None) -> None:
    """Print the robot's URDF: of a xacro file, what it expands to."""
    text = load_robot(robot, xacro_arg, package_dir).to_urdf()
    typer.echo(text.encode(), nl=False)
