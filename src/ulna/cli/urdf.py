"""``ulna urdf``: the URDF text of a robot."""

from typing import Annotated

import typer

from ulna.cli.depends import command
from ulna.cli.options import RobotName, Sources
from ulna.description.load import urdf_text

MeshPaths = Annotated[
    str, typer.Option(metavar="KIND", help="given: as in the file; file: absolute file:// addresses, as RViz needs.")
]


@command
def urdf(sources: Sources, *, robot: RobotName = "panda", mesh_paths: MeshPaths = "given") -> None:
    """Print the robot's URDF; a xacro file is expanded.

    The text is printed even if it cannot be loaded, so that you can look up the line that an error names.
    """
    typer.echo(urdf_text(robot, **sources, mesh_paths=mesh_paths).encode(), nl=False)
