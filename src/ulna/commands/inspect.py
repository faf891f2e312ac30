"""``ulna inspect``: the health of a description."""

import typer

import ulna
from ulna.answers.inspection import inspection_data
from ulna.commands.options import Json, PackageDirs, RobotName, XacroArgs, xacro_arguments
from ulna.inspection.result import Severity
from ulna.tables.inspection import inspection_view
from ulna.tables.writing import show

_EXIT_STATUS = {None: 0, Severity.NOTE: 0, Severity.WARNING: 1, Severity.ERROR: 2}


def inspect(
    robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None, as_json: Json = False
) -> None:
    """The health of a description, also of one that cannot be loaded: limits, axes, units, meshes, inertia, and its tree.

    Exit status 0 if nothing is wrong (notes do not count), 1 if something looks wrong (warnings), 2 if something is (errors).
    """
    inspection = ulna.inspect(robot, xacro_args=xacro_arguments(xacro_arg), package_dirs=package_dir or ())
    show(inspection_data(inspection), None if as_json else inspection_view)
    raise typer.Exit(_EXIT_STATUS[inspection.worst])
