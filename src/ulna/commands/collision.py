"""``ulna check``: whether a robot touches boxes."""

from typing import Annotated

import typer

import ulna
from ulna.answers.collision import report_data
from ulna.commands.numbers import BOX, numbers
from ulna.commands.options import Degrees, Json, PackageDirs, Positions, RobotName, XacroArgs, load_robot, positions
from ulna.tables.collision import report_view
from ulna.tables.writing import show


def check(
    robot: RobotName = "panda",
    *,
    box: Annotated[
        list[str],
        typer.Option(
            metavar="NUMBERS", help='A box: "x, y, z, roll, pitch, yaw, length, width, height"; repeatable: box 1, box 2 ...'
        ),
    ],
    q: Positions = None,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Whether the robot touches boxes, and how deep.

    As in: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126". Exit status 0 if it is free, 1 if not.
    """
    arm = load_robot(robot, xacro_arg, package_dir)
    world = ulna.World()
    for k, text in enumerate(box, start=1):
        *place, length, width, height = numbers("--box", text, BOX, degrees=degrees)
        world.add(f"box {k}", ulna.Box((length, width, height)), ulna.pose(place[:3], place[3:]))
    at = positions("--q", q, arm, degrees=degrees)
    report = arm.check_collision(at, world)
    show(report_data(arm, at, report), None if as_json else report_view)
    raise typer.Exit(1 if report.in_collision else 0)
