"""``ulna follow``: the joint path through a path of poses."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.cell import Meshes, Obstacles, checked_robot
from ulna.cli.depends import Json, as_options, command, defaults_of
from ulna.cli.joint_plot import PlotFile, draw_joints, write_figure
from ulna.cli.options import AnyRobot, Link
from ulna.cli.output import Data, Output, limit, make_table, number
from ulna.cli.rows import read_poses
from ulna.cli.targets import StartQ
from ulna.description.table_file import write_table
from ulna.ik.followed_path import FollowedPath
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Poses = Annotated[
    Path,
    typer.Option(
        "--path",
        metavar="FILE",
        help="The poses: rows of x, y, z and roll, pitch, yaw (or w, x, y, z, or a matrix) in a .csv file, or a .npy file.",
    ),
]
Out = Annotated[Path | None, typer.Option("--csv", metavar="FILE", help="Write the joint path, a row a pose, its names first.")]
MaxStep = Annotated[float, typer.Option(metavar="NUMBER", help="The largest step of a joint from pose to pose [rad or m].")]
Rank = Annotated[
    str | None, typer.Option(metavar="NAME", help="What is minimised: nearest, manipulability, clearance or mid_range.")
]

FOLLOW_KEYS = (
    "robot; base; link; poses: how many; status; success; reason; sentence; proof: complete or searched; max_step; "
    "largest_step; ends_at: the first pose that is not reached, from 0, or null; joints; units; lower; upper; q: rows, null from "
    "there on; alive, smallest_step, manipulability, least_singular_value, limit_excess, collisions: why it ends, or null."
)
_ENDING = ("alive", "smallest_step", "manipulability", "least_singular_value", "limit_excess", "collisions")
_DEFAULTS = defaults_of(Robot.follow)


@command
def follow(
    robot: AnyRobot,
    link: Link,
    start: StartQ,
    *,
    T_path: Poses,
    world: Obstacles,
    csv: Out = None,
    plot: PlotFile = None,
    max_step: MaxStep = _DEFAULTS["max_step"],
    rank: Rank = None,
    meshes: Meshes = None,
    as_json: Json = False,
) -> Output:
    """The joint path through a path of poses that never jumps, or where and why there is none.

    As in: ulna follow panda --path line.csv --csv joints.csv. To see it move: ulna record line.mp4 --robot panda --trajectory
    joints.csv. With --scene or --box it is clear of the obstacles and of itself. Unless --from says where the arm is before, the
    path begins anywhere; with --rank nearest, near home. Exit status 0 if all poses are reached, 1 if not.
    """
    if world is not None:
        robot = checked_robot(robot, meshes=meshes, as_json=as_json)
    with as_options({"q_start": "--from"}):
        found = robot.follow(read_poses(T_path), start, link=link, max_step=max_step, world=world, rank=rank)
    if csv is not None:
        write_table(csv, found.joint_names, found.q[: found.ends_at])  # the rows that are reached
    if plot is not None:
        write_figure(draw_joints(robot, found), plot)
    return Output(follow_data(robot, link, found), follow_table, status=0 if found.success else 1)


def follow_data(robot: Robot, link: str, found: FollowedPath) -> Data:
    """The joint path; see ``FOLLOW_KEYS``."""
    known = found.steps[np.isfinite(found.steps)]
    return {
        "robot": robot.name,
        "base": robot.base,
        "link": link,
        "poses": len(found.q),
        "status": str(found.status),
        "success": found.success,
        "reason": str(found.reason),
        "sentence": str(found),
        "proof": str(found.proof),
        "max_step": found.max_step,
        "largest_step": float(known.max(initial=0.0)),
        "ends_at": found.ends_at,
        "joints": [entry.name for entry in coordinates_of(robot)],
        "units": [entry.unit for entry in coordinates_of(robot)],
        "lower": robot.lower,
        "upper": robot.upper,
        "q": found.q,
        **{key: getattr(found.reason.data, key) if found.reason else None for key in _ENDING},
    }


def follow_table(data) -> Iterator[RenderableType]:
    """For each joint where it begins and ends, and how far it goes, between its limits; then the status."""
    yield Text(f"{data['robot']}: {data['link']} in {data['base']}, {data['poses']} poses", "bold")
    rows = data["q"][: data["ends_at"]]
    if rows:
        table = make_table(["joint"], ["begins", "ends", "least", "most", "lower", "upper", ""], [])
        for k, (name, unit) in enumerate(zip(data["joints"], data["units"], strict=True)):
            q = [row[k] for row in rows]
            limits = map(limit, (data["lower"][k], data["upper"][k]))
            table.add_row(name, *(number(x, 4) for x in (q[0], q[-1], min(q), max(q))), *limits, unit)
        yield table
    yield Text(data["sentence"], "bold green" if data["success"] else "bold red")
