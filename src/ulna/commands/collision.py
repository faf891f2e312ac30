"""``ulna check``: whether a robot touches boxes or itself."""

from typing import Annotated

import typer

import ulna
from ulna.answers.collision import report_data
from ulna.commands.numbers import BOX, numbers
from ulna.commands.options import (
    Degrees,
    Hulls,
    Json,
    PackageDirs,
    Positions,
    RobotName,
    Scene,
    XacroArgs,
    load_robot,
    load_scene,
    positions,
)
from ulna.tables.collision import report_view
from ulna.tables.writing import show


def check(
    robot: RobotName = "panda",
    *,
    box: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBERS", help='A box: "x, y, z, roll, pitch, yaw, length, width, height"; repeatable: box 1, box 2 ...'
        ),
    ] = None,
    scene: Scene = None,
    q: Positions = None,
    itself: Annotated[bool, typer.Option("--self/--no-self", help="Check the robot's links against each other too.")] = True,
    hulls: Hulls = False,
    within: Annotated[float, typer.Option(min=0, metavar="METRES", help="Show pairs too that are so near.")] = 0.0,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Whether the robot touches itself or boxes, how deep and where, and how far it is from them.

    As in: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126", or: ulna check --scene scene.json. Exit status 0 if it is
    free, 1 if not.
    """
    arm = load_robot(robot, xacro_arg, package_dir)
    if hulls:
        arm = arm.with_convex_hulls()
    world = load_scene(scene)
    for k, text in enumerate(box or (), start=1):
        *place, length, width, height = numbers("--box", text, BOX, degrees=degrees)
        world.add(f"box {k}", ulna.Box((length, width, height)), ulna.pose(place[:3], place[3:]))
    at = positions("--q", q, arm, degrees=degrees)
    report = arm.check_collision(at, world, itself, max_distance=within)
    distance = arm.signed_distance(at, world, itself)
    show(report_data(arm, at, report, distance), None if as_json else report_view)
    raise typer.Exit(1 if report.in_collision else 0)
