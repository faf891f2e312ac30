"""``ulna check``: whether a robot touches obstacles or itself."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Annotated

import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.cell import CheckedRobot, Obstacles
from ulna.cli.depends import command
from ulna.cli.output import Q_KEYS, Output, attributes, data_of_q, make_table, number, title
from ulna.cli.targets import Q
from ulna.collision.report import Pair
from ulna.collision.world import World
from ulna.description.meshes.hulls import in_place_of_meshes

SelfCollision = Annotated[bool, typer.Option("--self/--no-self", help="Check the robot's links against each other too.")]
Within = Annotated[float, typer.Option("--within", metavar="METRES", help="Show pairs that are free but nearer than this too.")]

CHECK_KEYS = (
    f"{Q_KEYS}; in_place_of_meshes: what of them is checked, in words, or null; "
    "in_collision; signed_distance: the least, null if there is nothing to measure to; touching: shapes of the "
    "robot; pairs: name_a of the robot, link_a, name_b and link_b (null: of the world), signed_distance (negative: overlap), "
    "witness_a and witness_b: the nearest points, normal from a to b, point: which of a cloud, from 0, else null."
)
_OF_PAIR = (*(field.name for field in fields(Pair) if not field.name.startswith("_")), "point")


@command
def check(
    robot: CheckedRobot, world: Obstacles, q: Q, *, self_collision: SelfCollision = True, max_distance: Within = 0.0
) -> Output:
    """Whether the robot touches itself or boxes, how deep and where, and how far it is from them.

    As in: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126", or: ulna check --scene scene.json. Exit status 0 if it is
    free, 1 if not.
    """
    around = world or World()
    report = robot.check_collision(q, around, self_collision=self_collision, max_distance=max_distance)
    data = {
        **data_of_q(robot, q),
        "in_place_of_meshes": in_place_of_meshes(robot.description) or None,
        "in_collision": report.in_collision,
        "signed_distance": robot.signed_distance(q, around, self_collision=self_collision),
        "touching": report.touching,
        "pairs": [attributes(pair, *_OF_PAIR) for pair in report.pairs],
    }
    return Output(data, check_table, status=1 if report.in_collision else 0)


def check_table(data) -> Iterator[RenderableType]:
    """The pairs, deepest first, the least distance, and "collision" or "free"."""
    yield title(data, "collision check")
    if data["pairs"]:
        table = make_table(["robot", "link", "other"], ["apart [mm]"], ["normal", "at [m]"])
        for pair in data["pairs"]:
            vectors = [" ".join(number(x, n) for x in pair[key]) for key, n in (("normal", 2), ("witness_a", 3))]
            other = pair["name_b"] if pair["point"] is None else f"{pair['name_b']}, point {pair['point']}"
            table.add_row(pair["name_a"], pair["link_a"], other, f"{1000 * pair['signed_distance'] + 0.0:.3f}", *vectors)
        yield table
    if data["signed_distance"] is not None:
        yield f"least distance: {1000 * data['signed_distance'] + 0.0:.3f} mm"
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")
