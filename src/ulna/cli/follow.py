"""``ulna follow``: the joint path through a path of poses."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import RenderableType
from rich.text import Text

from ulna.cli.meshes import Meshes, refuse_meshes, with_chosen_shapes
from ulna.cli.options import (
    Base,
    Degrees,
    Json,
    Link,
    PackageDirs,
    RobotName,
    Scene,
    SrdfFile,
    Tip,
    XacroArgs,
    as_options,
    link_or_hand,
    load_robot,
    positions,
    world_of,
)
from ulna.cli.output import Data, limit, make_table, number, show
from ulna.cli.trajectory import read_poses
from ulna.errors import FileError, needs_extra
from ulna.ik.following.result import FollowedPath
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
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw the joints over the poses: .png, .svg or .pdf.")]
Start = Annotated[str | None, typer.Option(metavar="NUMBERS", help="Where the arm is before; anywhere unless given.")]
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


def follow(
    robot: RobotName = "panda",
    *,
    path: Poses,
    csv: Out = None,
    plot: Plot = None,
    q_start: Start = None,
    link: Link = None,
    max_step: MaxStep = 0.1,
    scene: Scene = None,
    rank: Rank = None,
    meshes: Meshes = None,
    degrees: Degrees = False,
    base: Base = None,
    tip: Tip = None,
    srdf: SrdfFile = None,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """The joint path through a path of poses that never jumps, or where and why there is none.

    As in: ulna follow panda --path line.csv --csv joints.csv. To see it move: ulna record line.mp4 --robot panda --trajectory
    joints.csv. With --scene it is clear of the obstacles and of itself. Exit status 0 if all poses are reached, 1 if not.
    """
    arm = load_robot(robot, xacro_arg, package_dir, base=base, tip=tip, srdf=srdf)
    if scene is not None:
        arm = with_chosen_shapes(arm, meshes, hulls=False, quiet=as_json)
        refuse_meshes(arm)
    link = link_or_hand(arm, link, quietly=as_json)
    poses, world = read_poses(path), None if scene is None else world_of(scene)
    start = None if q_start is None else positions("--q-start", q_start, arm, degrees=degrees)
    with as_options({"max_step": "--max-step", "rank": "--rank", "q_start": "--q-start", "T_path": "--path"}):
        found = arm.follow(poses, start, link=link, max_step=max_step, world=world, rank=rank)
    if csv is not None:
        write_rows(found, csv)
    if plot is not None:
        with needs_extra("a figure", "reach", "matplotlib"):
            from ulna.cli.joint_plot import write_joints  # noqa: PLC0415 -- needs the extra
        write_joints(arm, found, plot)
    show(follow_data(arm, link, found), follow_table, as_json=as_json)
    raise typer.Exit(0 if found.success else 1)


def write_rows(found: FollowedPath, path: Path) -> None:
    """Write the rows that are reached, after a line of names.

    Raises:
        FileError: The file cannot be written.
    """
    rows = found.q[: found.ends_at]
    lines = [",".join(found.joint_names), *(",".join(repr(float(x)) for x in row) for row in rows)]
    try:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise FileError(str(path), error.strerror or str(error)) from None


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
