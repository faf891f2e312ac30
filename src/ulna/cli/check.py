"""``ulna check``: checks a configuration or a motion for collisions with obstacles and with the robot itself."""

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.cell import CheckedRobot, Obstacles
from ulna.cli.depends import as_options, command
from ulna.cli.options import Degrees, HandAcceleration, HandSpeed, hand_of, warnings_printed
from ulna.cli.output import Q_KEYS, Output, attributes, data_of_q, make_table, number, title
from ulna.cli.plan import ArmLimits
from ulna.cli.targets import Positions, q_of
from ulna.collision.report import Pair
from ulna.collision.world import World
from ulna.description.meshes.hulls import in_place_of_meshes
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.robot.motion_file import motion_of_file

SelfCollision = Annotated[bool, typer.Option("--self/--no-self", help="Check the robot's links against each other too.")]
Within = Annotated[float, typer.Option("--within", metavar="METERS", help="Also show free pairs that are closer than this.")]

MotionFile = Annotated[
    Path | None,
    typer.Option("--motion", metavar="FILE", help="Check a motion: of `ulna plan --csv`, a message of ROS, or a plan of MoveIt."),
]
_PERIOD = 0.001  # [s], the period of the samples that are searched for the first contact of a motion

CHECK_KEYS = (
    f"{Q_KEYS}; in_place_of_meshes: the shapes checked in their place, in words, or null; "
    "in_collision; signed_distance: the minimum, null if there is nothing to measure to; touching: shapes of the "
    "robot; pairs: name_a of the robot, link_a, name_b and link_b (null: of the world), signed_distance (negative: overlap), "
    "witness_a and witness_b: the nearest points, normal from a to b, point: its index in a cloud, else null. With --motion: "
    "robot; in_collision: whether a sample touches; touches_at: time of the first contact, in seconds, or null; "
    "certified: whether all of it is certified free; within_limits; check: the verdict in words; duration, in seconds."
)
_PAIR_FIELDS = (*(field.name for field in fields(Pair) if not field.name.startswith("_")), "point")


@command
def check(
    robot: CheckedRobot,
    world: Obstacles,
    *,
    q: Positions = None,
    degrees: Degrees = False,
    self_collision: SelfCollision = True,
    max_distance: Within = 0.0,
    motion: MotionFile = None,
    limits: ArmLimits = None,
    hand_speed: HandSpeed = None,
    hand_acceleration: HandAcceleration = None,
) -> Output:
    """Check whether the robot touches itself or obstacles: where, how deep, and the distance if it is free.

    Example: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126", or: ulna check --scene scene.json. Exit status 0 if it is free,
    1 if not. For a motion: ulna check --motion motion.csv --limits franka. Exit status 0 if the motion is certified free and
    within its limits.
    """
    around = world or World()
    if motion is not None:
        if q is not None or not self_collision or max_distance:
            raise InputError("--q, --no-self, --within", "apply to a configuration, not to --motion")
        with as_options({"limits": "--limits", "hand": "--hand-speed"}):
            return _check_motion(robot, around, motion, limits, hand_speed, hand_acceleration)
    for option, given in (("--limits", limits), ("--hand-speed", hand_speed), ("--hand-acceleration", hand_acceleration)):
        if given is not None:
            raise InputError(option, "requires --motion")
    return _check_configuration(
        robot, around, q_of(robot, q=q, degrees=degrees), self_collision=self_collision, within=max_distance
    )


def _check_motion(
    robot: Robot, around: World, path: Path, limits: str | None, speed: float | None, acceleration: float | None
) -> Output:
    """Check whether a motion is free, and within its limits."""
    with warnings_printed():
        motion = motion_of_file(robot, path, option="--motion")
    judged = motion.check(limits, hand=hand_of(robot, speed, acceleration))
    certified = motion.is_free(around)
    samples = motion.sampled(_PERIOD)
    touching = np.flatnonzero([] if certified else robot.in_collision(samples.q, around))
    data = {
        "robot": robot.name,
        "in_collision": bool(len(touching)),
        "touches_at": float(samples.t[touching[0]]) if len(touching) else None,
        "certified": certified,
        "within_limits": bool(judged),
        "check": str(judged),
        "duration": motion.duration,
    }
    return Output(data, motion_table, status=0 if certified and judged else 1)


def motion_table(data) -> Iterator[RenderableType]:
    """Show a sentence about the limits, and whether the motion is free."""
    yield Text(f"{data['robot']}: a motion of {data['duration']:.3f} s", "bold")
    yield data["check"]
    if data["in_collision"]:
        yield Text(f"collision at {data['touches_at']:.3f} s", "bold red")
    elif data["certified"]:
        yield Text("certified free", "bold green")
    else:
        yield Text("not certified free; no contact at samples every 1 ms", "bold yellow")


def _check_configuration(robot: Robot, around: World, q, *, self_collision: bool, within: float) -> Output:
    report = robot.check_collision(q, around, self_collision=self_collision, max_distance=within)
    data = {
        **data_of_q(robot, q),
        "in_place_of_meshes": in_place_of_meshes(robot.description) or None,
        "in_collision": report.in_collision,
        "signed_distance": robot.signed_distance(q, around, self_collision=self_collision),
        "touching": report.touching,
        "pairs": [attributes(pair, *_PAIR_FIELDS) for pair in report.pairs],
    }
    return Output(data, check_table, status=1 if report.in_collision else 0)


def check_table(data) -> Iterator[RenderableType]:
    """Show the pairs, deepest first, the minimum distance, and "collision" or "free"."""
    yield title(data, "collision check")
    if data["pairs"]:
        table = make_table(["robot", "link", "other"], ["distance [mm]"], ["normal", "at [m]"])
        for pair in data["pairs"]:
            vectors = [" ".join(number(x, n) for x in pair[key]) for key, n in (("normal", 2), ("witness_a", 3))]
            other = pair["name_b"] if pair["point"] is None else f"{pair['name_b']}, point {pair['point']}"
            table.add_row(pair["name_a"], pair["link_a"], other, f"{1000 * pair['signed_distance'] + 0.0:.3f}", *vectors)
        yield table
    if data["signed_distance"] is not None:
        yield f"minimum distance: {1000 * data['signed_distance'] + 0.0:.3f} mm"
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")
