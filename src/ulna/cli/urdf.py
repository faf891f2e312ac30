"""``ulna urdf``: the URDF text of a robot."""

from typing import Annotated

import typer

from ulna.cli.options import PackageDirs, RobotName, XacroArgs, xacro_arguments
from ulna.description.load import urdf_text

MeshPaths = Annotated[
    str, typer.Option(metavar="KIND", help="given: as in the file; file: absolute file:// addresses, as RViz needs.")
]


def urdf(
    robot: RobotName = "panda",
    *,
    mesh_paths: MeshPaths = "given",
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
) -> None:
    """Print the robot's URDF: of a xacro file, what it expands to.

    It is printed even if it cannot be loaded, so that the line that an error names can be looked up.
    """
    typer.echo(urdf_text(robot, xacro_arguments(xacro_arg), package_dir or (), mesh_paths).encode(), nl=False)
