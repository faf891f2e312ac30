"""``ulna compare``: how two descriptions of one robot differ."""

from typing import Annotated

import typer

import ulna
from ulna.answers.comparison import comparison_data
from ulna.commands.options import Json, PackageDirs, load_robot
from ulna.comparison.result import KINDS
from ulna.tables.comparison import comparison_view
from ulna.tables.writing import show


def compare(
    a: Annotated[str, typer.Argument(metavar="A", help="A bundled name, or the path of a .urdf or .xacro file.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Another one.")],
    *,
    ignore: Annotated[
        list[str] | None, typer.Option(metavar="KIND", help=f"Differences that do not count; repeatable: {', '.join(KINDS)}.")
    ] = None,
    position: Annotated[float, typer.Option(metavar="M", help="Distances that count as none.")] = 1e-6,
    rotation: Annotated[float, typer.Option(metavar="RAD", help="Angles that count as none.")] = 1e-6,
    limit: Annotated[float, typer.Option(metavar="NUMBER", help="Differences of limits that count as none.")] = 1e-6,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """How two descriptions of one robot differ: names, types, limits, axes, shapes, and where the links stand.

    As in: ulna compare panda my_panda.urdf --ignore visual --ignore collision.
    Exit status 0 if nothing differs, 1 if something does, 2 if one of them cannot be read.
    """
    comparison = ulna.compare(
        load_robot(a, None, package_dir),
        load_robot(b, None, package_dir),
        ignore=ignore or (),
        position_tolerance=position,
        rotation_tolerance=rotation,
        limit_tolerance=limit,
    )
    show(comparison_data(comparison), None if as_json else comparison_view)
    raise typer.Exit(0 if comparison.same else 1)
