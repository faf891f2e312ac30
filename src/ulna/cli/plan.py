"""``ulna plan``: plans a collision-free motion to a goal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.progress import TextColumn, TimeElapsedColumn

from ulna.cli.cell import CheckedRobot, Obstacles
from ulna.cli.depends import Json, as_options, command, defaults_of
from ulna.cli.keeps import KeepTexts, keep_of
from ulna.cli.loads import MotorLoads
from ulna.cli.options import Degrees, HandAcceleration, HandSpeed, Jerk, LinkName, Seed, hand_of, named_or_hand
from ulna.cli.output import Data, Output, PlotFile, attributes, make_table, number, write_figure
from ulna.cli.targets import HOME, RPY, XYZ, Start, TargetPose, numbers, positions, state_of, target_pose, words
from ulna.description.pose import pose
from ulna.engine.progress import progress_bar
from ulna.errors import InputError
from ulna.kinematics.groups import JointGroup, group_named, tip_of
from ulna.kinematics.tree import entry_names
from ulna.planning.motion_limits import as_limits, limits_of
from ulna.planning.plan import Plan
from ulna.robot import Robot
from ulna.robot.coordinates import coordinates_of

Goal = Annotated[
    str | None,
    typer.Option("--to", metavar="NUMBERS", help="Joint positions to reach, or a state of the SRDF, as in arm/ready, or home."),
]
GroupName = Annotated[
    str | None, typer.Option(metavar="NAME", help="A group of the SRDF: only its joints move, and --to has only these.")
]
Position = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Or the position of the link to reach, in meters.")]
Goals = Annotated[
    list[str] | None,
    typer.Option(
        "--goal",
        metavar="LINK=NUMBERS",
        help='Or "LINK=x,y,z,roll,pitch,yaw" or "LINK=x,y,z"; repeatable: several links come to their poses together.',
    ),
]
Held = Annotated[
    list[str] | None,
    typer.Option(metavar="JOINT", help="A joint that keeps its position, such as a lift or a finger; repeatable."),
]
Clearance = Annotated[float, typer.Option(metavar="METERS", help="Minimum distance from objects.")]
MaxChecks = Annotated[int, typer.Option(help="Maximum number of edge checks.")]
TimeLimit = Annotated[float, typer.Option(metavar="SECONDS", help="Time limit of the search; inf for none.")]
Sampled = Annotated[bool, typer.Option("--sampled", help="Check edges at samples instead of certifying them.")]
Escape = Annotated[bool, typer.Option("--escape", help="Leave a start that touches by at most 10 mm, or is beyond limits.")]
Velocity = Annotated[
    float | None, typer.Option(metavar="NUMBER", help="Maximum velocity of every joint [rad/s or m/s], within its own limit.")
]
Acceleration = Annotated[
    float | None,
    typer.Option(metavar="NUMBER", help="Maximum acceleration of every joint [rad/s^2 or m/s^2]; 5 without --limits."),
]
ArmLimits = Annotated[
    str | None,
    typer.Option(
        "--limits",
        metavar="NAME",
        help="Limits of velocity, acceleration and jerk: of an arm such as franka, or a file joint_limits.yaml; "
        "numbers override them. The plan  keeps the file's position limits too.",
    ),
]
Csv = Annotated[Path | None, typer.Option(metavar="FILE", help="Write the timed motion: one row per --period.")]
Period = Annotated[float, typer.Option(metavar="SECONDS", help="The time between two rows of --csv.")]
_VELOCITY = 1.0  # [rad/s or m/s], for joints without a limit
_ACCELERATION = 5.0  # [rad/s^2 or m/s^2]
_DEFAULTS = defaults_of(Robot.plan)

PLAN_KEYS = (
    "robot; status; success; reason; joints; path: rows of q; length; certified; moved: joints that move although their position "
    "is the same at both ends, since no path was found with them held; worst_violation: the largest share of its "
    "tolerance that a constraint uses on the path, as an upper bound; clearance, in meters, null without objects; "
    "checks; duration of the fastest motion within the limits, in seconds, or null; check: the sample, every 1 ms, that "
    "comes nearest to a limit, as a sentence, or null; files: those that were written."
)


@command
def plan(
    robot: CheckedRobot,
    loads: MotorLoads,
    *,
    start: Start = None,
    to: Goal = None,
    xyz: Position = None,
    target: TargetPose,
    goals: Goals = None,
    link: LinkName = None,
    group: GroupName = None,
    held: Held = None,
    world: Obstacles,
    keep: KeepTexts = None,
    clearance: Clearance = _DEFAULTS["clearance"],
    seed: Seed = _DEFAULTS["seed"],
    max_checks: MaxChecks = _DEFAULTS["max_checks"],
    time_limit: TimeLimit = _DEFAULTS["time_limit"],
    sampled: Sampled = False,
    escape: Escape = False,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    jerk: Jerk = None,
    limits: ArmLimits = None,
    hand_speed: HandSpeed = None,
    hand_acceleration: HandAcceleration = None,
    csv: Csv = None,
    period: Period = 0.01,
    plot: PlotFile = None,
    degrees: Degrees = False,
    as_json: Json = False,
) -> Output:
    """Plan a collision-free motion to a goal: RRT-Connect with certified edges, timed as fast as the limits allow.

    Example: ulna plan --to "1,-pi/4,0,-3pi/4,0,pi/2,pi/4" --csv motion.csv. The motion starts at home unless --from gives a
    start. Exit status 0 if a motion is found, 1 if not.
    """
    if sum(bool(given) for given in (to is not None, xyz is not None, target.whole is not None, goals)) != 1:
        raise InputError("--to, --xyz, --pose, --goal", "one of them is expected")
    if (to is not None or goals) and (link is not None or target.is_given):
        other = "--goal names its links and their orientations" if goals else "--to gives positions of all joints"
        raise InputError("--link, --rpy, --wxyz, --rotvec, --frame", f"require --xyz or --pose; {other}")
    if limits is not None:
        with as_options({"limits": "--limits"}):
            robot = _within_positions(robot, limits)
    members = None if group is None else group_named(group, robot.groups)
    begin = robot.home if start is None else positions("--from", start, robot, members, degrees=degrees)
    if to is not None:
        goal = _configuration(to, robot, members, degrees=degrees)
    elif goals:
        goal = _poses(goals, robot, degrees=degrees)
    else:
        link = tip_of(members) if members and link is None else named_or_hand(robot, link=link, as_json=as_json)
        goal = target_pose(robot, link, xyz, target)
    robot = loads.on(robot, link)
    keeps = [keep_of(text, degrees=degrees) for text in keep or ()]
    options = {
        "keep": "--keep",
        "held": "--held",
        "q_start": "--from",
        "goal": "--goal" if goals else "--to" if to is not None else "--xyz" if target.whole is None else "--pose",
        "frame": "--frame",
    }
    with as_options(options), search_shown() as progress:
        found = robot.plan(
            begin, goal, world, link=link, frame=target.frame, held=held or (), group=group, keep=keeps, certify=not sampled,
            clearance=clearance, seed=seed, max_checks=max_checks, time_limit=time_limit, escape=escape, progress=progress,
        )  # fmt: skip
    motion = None
    if found:
        accelerations = acceleration
        if limits is None and acceleration is None:
            own = robot.acceleration_limits
            accelerations = np.where(np.isinf(own), _ACCELERATION, own)
        velocities = None if limits is not None and velocity is None else _velocities(robot, velocity)
        with as_options({name: f"--{name}" for name in ("limits", "velocity", "acceleration", "jerk", "period", "torque")}):
            hand, most = hand_of(robot, hand_speed, hand_acceleration, link), loads.limits(robot)
            motion = found.trajectory(
                velocity=velocities, acceleration=accelerations, jerk=jerk, limits=limits, hand=hand, torque=most
            )
            if csv is not None:
                motion.to_csv(csv, period=period)
        if plot is not None:
            write_figure(motion.plot(), plot)
    data = {
        **found_data(robot, found),
        **attributes(found, "length", "certified", "moved", "worst_violation", "clearance", "checks"),
        "duration": motion and motion.duration,
        "check": motion and str(motion.check()),
        "files": [str(file) for file in (csv, plot) if file is not None and motion is not None],
    }
    return Output(data, plan_table, status=0 if found else 1)


def _configuration(text: str, robot: Robot, group: JointGroup | None, *, degrees: bool) -> str | NDArray[np.float64]:
    """The key of a state of the SRDF, or q; with a group, the q of its joints alone.

    The joints that a state leaves out keep their positions.
    """
    state = state_of(text, robot, group)
    if state is not None or group is None:
        return state or positions("--to", text, robot, degrees=degrees)
    columns = list(group.columns)
    if text == HOME:
        return robot.home[columns]
    entries = coordinates_of(robot)
    return np.array(numbers("--to", text, [entries[column] for column in columns], degrees=degrees))


def _within_positions(robot: Robot, limits: str) -> Robot:
    """The robot with position limits tightened to those of a file, if the file states any."""
    stated = limits_of(limits, entry_names(robot.tree), robot.tree.followers, ())
    if stated.lower is None or stated.upper is None:
        return robot
    return robot.with_limits(lower=np.maximum(robot.lower, stated.lower), upper=np.minimum(robot.upper, stated.upper))


def _velocities(robot: Robot, velocity: float | None) -> NDArray[np.float64]:
    """The velocity limit of each entry of q [rad/s or m/s], shape (n_dof,)."""
    own = robot.velocity_limits
    if velocity is None:
        return np.where(np.isinf(own), _VELOCITY, own)
    return np.minimum(own, as_limits("velocity", velocity, robot.n_dof))


def _poses(goals: list[str], robot: Robot, *, degrees: bool) -> dict[str, NDArray[np.float64]]:
    """The pose of each link, shape (4, 4), from "LINK=x, y, z" or "LINK=x, y, z, roll, pitch, yaw"."""
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


@contextmanager
def search_shown() -> Iterator[Callable[[int, int], None]]:
    """Show the progress of a search on standard error, if that is a terminal; yields the ``progress`` of ``Robot.plan``."""
    with progress_bar(TextColumn("planning"), TimeElapsedColumn(), TextColumn("{task.completed:,} edges checked")) as bar:
        task = bar.add_task("", total=None)
        yield lambda checks, _: bar.update(task, completed=checks)


def found_data(robot: Robot, found: Plan) -> Data:
    """The result of a search as data."""
    return {
        "robot": robot.name,
        "status": str(found.status),
        "success": bool(found),
        "reason": str(found),
        "joints": robot.joint_names,
        "path": found.path,
    }


def plan_table(data) -> Iterator[RenderableType]:
    """Show the configurations of the path, and a sentence about it."""
    if data["success"]:
        table = make_table(["joint"], [str(k) for k in range(1, len(data["path"]) + 1)], [])
        for k, name in enumerate(data["joints"]):
            table.add_row(name, *(number(q[k]) for q in data["path"]))
        if len(data["joints"]) == len(data["path"][0]):
            yield table
    yield data["reason"]
    if data["worst_violation"]:
        yield f"the motion uses at most {data['worst_violation']:.1%} of the constraints' tolerance"
    if data["duration"] is not None:
        yield f"{data['duration']:.3f} s, {data['check']}"
    yield from map("written: {}".format, data["files"])
