"""``ulna compare``: lists the differences between two descriptions of one robot."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.depends import command, defaults_of
from ulna.cli.options import Loading, load_robot
from ulna.cli.output import Output, attributes, make_table
from ulna.errors import count_of
from ulna.inspection.compare import compare as compare_robots
from ulna.inspection.differences import KINDS

First = Annotated[str, typer.Argument(metavar="A", help="A bundled name, or the path of a .urdf, .xacro or .sdf file.")]
Second = Annotated[str, typer.Argument(metavar="B", help="The other description.")]
Ignored = Annotated[
    list[str] | None, typer.Option(metavar="KIND", help=f"Differences that do not count; repeatable: {', '.join(KINDS)}.")
]
Meters = Annotated[float, typer.Option("--position", metavar="M", help="Distances up to this do not count.")]
Radians = Annotated[float, typer.Option("--rotation", metavar="RAD", help="Angles up to this do not count.")]
OfLimits = Annotated[float, typer.Option("--limit", metavar="NUMBER", help="Differences of limits up to this do not count.")]

COMPARE_KEYS = (
    "same; name_a; name_b; matched_by: name or order; differences: kind, where, a, b (in words); max_position_difference; "
    "max_rotation_difference; poses: link_a, link_b, and the largest position and rotation between them; frame_a and frame_b: "
    "the links in which poses are taken; n_configurations; tolerances."
)
_DEFAULTS = defaults_of(compare_robots)


@command
def compare(
    a: First,
    b: Second,
    loading: Loading,
    *,
    ignore: Ignored = None,
    position_tolerance: Meters = _DEFAULTS["position_tolerance"],
    rotation_tolerance: Radians = _DEFAULTS["rotation_tolerance"],
    limit_tolerance: OfLimits = _DEFAULTS["limit_tolerance"],
) -> Output:
    """Compare two descriptions of one robot: names, types, limits, axes, shapes, and the poses of the links.

    Example: ulna compare panda my_panda.urdf --ignore visual --ignore collision. Exit status 0 if nothing differs, 1 if something
    does, 2 if a file cannot be read.
    """
    comparison = compare_robots(
        load_robot(loading, robot=a),
        load_robot(loading, robot=b),
        ignore=ignore or (),
        position_tolerance=position_tolerance,
        rotation_tolerance=rotation_tolerance,
        limit_tolerance=limit_tolerance,
    )
    data = attributes(comparison, "same", "max_position_difference", "max_rotation_difference") | asdict(comparison)
    return Output(data, compare_table, status=0 if comparison.same else 1)


def compare_table(data) -> Iterator[RenderableType]:
    """Show a row for each difference, the largest distance between links, and the verdict."""
    by_order = "; names differ, so joints are matched by their order" if data["matched_by"] == "order" else ""
    yield Text.assemble((f"a: {data['name_a']}, b: {data['name_b']}", "bold"), by_order)
    if data["differences"]:
        table = make_table(["", "where", "a", "b"], [], [])
        table.columns[0].no_wrap = True
        for difference in data["differences"]:
            table.add_row(*(difference[key] for key in ("kind", "where", "a", "b")))
        yield table
    yield _largest_difference(data)
    yield Text("the same", "bold green") if data["same"] else Text(count_of(len(data["differences"]), "difference"), "bold red")


def _largest_difference(data) -> str:
    if not data["poses"]:
        return "no links match"
    farthest = max(data["poses"], key=lambda pose: (pose["position"], pose["rotation"]))
    where = f" ({farthest['link_a']})" if farthest["position"] > 0 else ""
    apart = f"{data['max_position_difference']:.3g} m{where}, {data['max_rotation_difference']:.3g} rad"
    return f"largest pose difference of {count_of(len(data['poses']), 'link')}, in {data['frame_a']}: {apart}"
