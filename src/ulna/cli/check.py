"""``ulna check``: whether a robot touches obstacles or itself."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.meshes import Hulls, Meshes, refuse_meshes, with_chosen_shapes
from ulna.cli.numbers import BOX, numbers
from ulna.cli.options import (
    Base,
    Degrees,
    Json,
    PackageDirs,
    Positions,
    RobotName,
    Scene,
    SrdfFile,
    Tip,
    XacroArgs,
    load_robot,
    positions,
    world_of,
)
from ulna.cli.output import Q_KEYS, Data, data_of_q, make_table, number, show, title
from ulna.collision.report import Report
from ulna.description.meshes.hulls import in_place_of_meshes
from ulna.description.pose import pose
from ulna.description.shapes import Box
from ulna.robot import Robot

Boxes = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NUMBERS", help='A box: "x, y, z, roll, pitch, yaw, length, width, height"; repeatable: box 1, box 2 ...'
    ),
]
SelfCollision = Annotated[bool, typer.Option("--self/--no-self", help="Check the robot's links against each other too.")]
Within = Annotated[float, typer.Option(min=0, metavar="METRES", help="Show pairs that are free but nearer than this too.")]

CHECK_KEYS = (
    f"{Q_KEYS}; in_place_of_meshes: what of them is checked, in words, or null; "
    "in_collision; signed_distance: the least, null if there is nothing to measure to; touching: shapes of the "
    "robot; pairs: name_a of the robot, link, name_b and link_b (null: of the world), signed_distance (negative: overlap), "
    "witness_a and witness_b: the nearest points, normal from a to b."
)


def check(
    robot: RobotName = "panda",
    *,
    box: Boxes = None,
    scene: Scene = None,
    q: Positions = None,
    itself: SelfCollision = True,
    meshes: Meshes = None,
    hulls: Hulls = False,
    within: Within = 0.0,
    degrees: Degrees = False,
    base: Base = None,
    tip: Tip = None,
    srdf: SrdfFile = None,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Whether the robot touches itself or boxes, how deep and where, and how far it is from them.

    As in: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126", or: ulna check --scene scene.json. Exit status 0 if it is
    free, 1 if not.
    """
    arm = load_robot(robot, xacro_arg, package_dir, base=base, tip=tip, srdf=srdf)
    arm = with_chosen_shapes(arm, meshes, hulls=hulls, quiet=as_json)
    refuse_meshes(arm)
    world = world_of(scene)
    for k, text in enumerate(box or (), start=1):
        *place, length, width, height = numbers("--box", text, BOX, degrees=degrees)
        world.add(f"box {k}", Box((length, width, height)), pose(place[:3], place[3:]))
    at = positions("--q", q, arm, degrees=degrees)
    report = arm.check_collision(at, world, self_collision=itself, max_distance=within)
    distance = arm.signed_distance(at, world, self_collision=itself)
    show(check_data(arm, at, report, distance), check_table, as_json=as_json)
    raise typer.Exit(1 if report.in_collision else 0)


def check_data(robot: Robot, q: NDArray[np.float64], report: Report, distance: float) -> Data:
    """The report of a collision check at q, shape (n_dof,), and the least distance [m]; see ``CHECK_KEYS``."""
    return {
        **data_of_q(robot, q),
        "in_place_of_meshes": in_place_of_meshes(robot.description) or None,
        "in_collision": report.in_collision,
        "signed_distance": distance,
        "touching": report.touching,
        "pairs": [{field.name: getattr(pair, field.name) for field in fields(pair)} for pair in report.pairs],
    }


def check_table(data) -> Iterator[RenderableType]:
    """The pairs, deepest first, the least distance, and "collision" or "free"."""
    yield title(data, "collision check")
    if data["pairs"]:
        table = make_table(["robot", "link", "other"], ["apart [mm]"], ["normal", "at [m]"])
        for pair in data["pairs"]:
            vectors = [" ".join(number(x, n) for x in pair[key]) for key, n in (("normal", 2), ("witness_a", 3))]
            table.add_row(pair["name_a"], pair["link"], pair["name_b"], f"{1000 * pair['signed_distance'] + 0.0:.3f}", *vectors)
        yield table
    if data["signed_distance"] is not None:
        yield f"least distance: {1000 * data['signed_distance'] + 0.0:.3f} mm"
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")
