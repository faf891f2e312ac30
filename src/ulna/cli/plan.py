"""``ulna plan``: a motion to a goal, free of collision."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import RenderableType

from ulna.cli.meshes import Hulls, Meshes, refuse_meshes, with_chosen_shapes
from ulna.cli.numbers import RPY, XYZ, is_name, numbers, words
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
    world_of,
)
from ulna.cli.output import Data, make_table, number, show
from ulna.description.pose import pose
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.groups import JointGroup, group_named, state_named, tip_of
from ulna.planning.options import MAX_CHECKS
from ulna.planning.plan import Plan
from ulna.planning.trajectory import Trajectory
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Start = Annotated[
    str | None,
    typer.Option("--from", metavar="NUMBERS", help="Joint positions to start from, or a state of the SRDF; home unless given."),
]
Goal = Annotated[
    str | None,
    typer.Option("--to", metavar="NUMBERS", help="Joint positions to reach, or a state of the SRDF, as in arm/home."),
]
GroupName = Annotated[
    str | None, typer.Option(metavar="NAME", help="A group of the SRDF: only its joints move, and --to has only these.")
]
Position = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Or the position of the link to reach, in metres.")]
RollPitchYaw = Annotated[str | None, typer.Option(metavar="R,P,Y", help="With --xyz: roll, pitch, yaw; as at home unless given.")]
Goals = Annotated[
    list[str] | None,
    typer.Option(
        "--goal",
        metavar="LINK=NUMBERS",
        help='Or "LINK=x,y,z,roll,pitch,yaw" or "LINK=x,y,z"; repeatable: several links come to their poses together.',
    ),
]
Clearance = Annotated[float, typer.Option(min=0, metavar="METRES", help="Keep objects at least this far away.")]
Seed = Annotated[int, typer.Option(min=0, help="Chooses the samples.")]
MaxChecks = Annotated[int, typer.Option(min=1, help="How many edges are checked at most.")]
Sampled = Annotated[bool, typer.Option("--sampled", help="Check edges at samples instead of certifying them.")]
Escape = Annotated[bool, typer.Option("--escape", help="Leave a start that touches something by at most 10 mm.")]
Acceleration = Annotated[float, typer.Option(min=0, metavar="NUMBER", help="The greatest of every joint [rad/s^2 or m/s^2].")]
Csv = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the motion in time: a row for each 10 ms.")]
_LARGEST_VELOCITY = 1.0  # [rad/s or m/s], of joints without a limit
_PERIOD = 0.01  # [s]
_OPTIONS = {name: f"--{name.replace('_', '-')}" for name in ("link", "group", "clearance", "seed", "max_checks", "acceleration")}
_OPTIONS["q_start"] = "--from"

PLAN_KEYS = (
    "robot; status; success; reason; joints; path: rows of q; length; certified; clearance, in metres, null without objects; "
    "checks; duration of the fastest motion within the limits, in seconds, or null."
)


def plan(
    robot: RobotName = "panda",
    *,
    start: Start = None,
    to: Goal = None,
    xyz: Position = None,
    rpy: RollPitchYaw = None,
    goals: Goals = None,
    scene: Scene = None,
    link: Link = None,
    group: GroupName = None,
    clearance: Clearance = 0.0,
    seed: Seed = 0,
    max_checks: MaxChecks = MAX_CHECKS,
    sampled: Sampled = False,
    escape: Escape = False,
    acceleration: Acceleration = 5.0,
    csv: Csv = None,
    meshes: Meshes = None,
    hulls: Hulls = False,
    degrees: Degrees = False,
    base: Base = None,
    tip: Tip = None,
    srdf: SrdfFile = None,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """A motion to a goal, free of collision: RRT-Connect with certified edges, and the fastest times within the limits.

    As in: ulna plan --to "1,-pi/4,0,-3pi/4,0,pi/2,pi/4" --csv motion.csv. Exit status 0 if a motion is found, 1 if not.
    """
    arm = load_robot(robot, xacro_arg, package_dir, base=base, tip=tip, srdf=srdf)
    arm = with_chosen_shapes(arm, meshes, hulls=hulls, quiet=as_json)
    refuse_meshes(arm)
    if sum(bool(given) for given in (to is not None, xyz is not None, goals)) != 1:
        raise InputError("--to, --xyz, --goal", "one of them is expected")
    if xyz is None and (link is not None or rpy is not None):
        other = "--goal names its links and their orientations" if goals else "--to gives positions of all joints"
        raise InputError("--link, --rpy", f"go with --xyz; {other}")
    members = None if group is None else group_named(group, arm.groups)
    begin = arm.home if start is None else _configuration("--from", start, arm, members, degrees=degrees)
    if to is not None:
        goal, link = _configuration("--to", to, arm, members, degrees=degrees), None
    elif goals:
        goal = _poses(goals, arm, degrees=degrees)
    else:
        with as_options(_OPTIONS):
            link = tip_of(members) if members and link is None else link_or_hand(arm, link, quietly=as_json)
        goal = arm.forward_kinematics(arm.home, link=link)
        if rpy is not None:
            goal = pose(rpy=numbers("--rpy", rpy, RPY, degrees=degrees))
        goal[:3, 3] = numbers("--xyz", str(xyz), XYZ)
    with as_options(_OPTIONS | {"goal": "--goal" if goals else "--xyz" if to is None else "--to"}):
        found = arm.plan(
            begin, goal, world_of(scene), link=link, group=group, certify=not sampled, clearance=clearance, seed=seed,
            max_checks=max_checks, escape=escape,
        )  # fmt: skip
        motion = _timed(arm, found, acceleration) if found else None
    if csv is not None and motion is not None:
        motion.to_csv(csv, period=_PERIOD)
    show(plan_data(arm, found, motion), plan_table, as_json=as_json)
    raise typer.Exit(0 if found else 1)


def _configuration(option: str, text: str, robot: Robot, group: JointGroup | None, *, degrees: bool) -> str | NDArray[np.float64]:
    """The name of a state of the SRDF; or numbers, for --to those of the group alone."""
    try:
        state_named(text, robot.srdf.states, group)
    except UnknownNameError:
        if is_name(text):
            raise
    else:
        return text
    entries = coordinates_of(robot)
    if group is not None and option == "--to":
        entries = [entries[column] for column in group.columns]
    return np.array(numbers(option, text, entries, degrees=degrees))


def _poses(goals: list[str], robot: Robot, *, degrees: bool) -> dict[str, NDArray[np.float64]]:
    """The pose of each link, shape (4, 4), of "LINK=x, y, z" or "LINK=x, y, z, roll, pitch, yaw"."""
    poses: dict[str, NDArray[np.float64]] = {}
    for text in goals:
        link, separator, values = text.rpartition("=")
        if not separator:
            raise InputError("--goal", f"{text!r}; LINK=x,y,z or LINK=x,y,z,roll,pitch,yaw is expected")
        if link in poses:
            raise InputError("--goal", f"the link {link!r} is named twice")
        if len(words(values)) == len(XYZ):
            poses[link] = robot.forward_kinematics(robot.home, link=link)
            poses[link][:3, 3] = numbers("--goal", values, XYZ)
        else:
            given = numbers("--goal", values, (*XYZ, *RPY), degrees=degrees)
            poses[link] = pose(given[:3], given[3:])
    return poses


def _timed(robot: Robot, found: Plan, acceleration: float) -> Trajectory:
    velocity = np.where(np.isinf(robot.velocity_limits), _LARGEST_VELOCITY, robot.velocity_limits)
    return found.trajectory(velocity=velocity, acceleration=acceleration)


def plan_data(robot: Robot, found: Plan, motion: Trajectory | None) -> Data:
    """A plan, and its times; see ``PLAN_KEYS``."""
    return {
        "robot": robot.name,
        "status": str(found.status),
        "success": bool(found),
        "reason": str(found),
        "joints": robot.joint_names,
        "path": found.path,
        "length": found.length,
        "certified": found.certified,
        "clearance": found.clearance,
        "checks": found.checks,
        "duration": None if motion is None else motion.duration,
    }


def plan_table(data) -> Iterator[RenderableType]:
    """The configurations of the path, and a sentence about it."""
    if data["success"]:
        table = make_table(["joint"], [str(k) for k in range(1, len(data["path"]) + 1)], [])
        for k, name in enumerate(data["joints"]):
            table.add_row(name, *(number(q[k]) for q in data["path"]))
        if len(data["joints"]) == len(data["path"][0]):
            yield table
    yield data["reason"]
    if data["duration"] is not None:
        yield f"{data['duration']:.3f} s within the limits"
