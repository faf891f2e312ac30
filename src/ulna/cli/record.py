"""``ulna record``: records videos and pictures without a display."""

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from ulna.cli.cell import Obstacles, warn_of_missing
from ulna.cli.depends import command
from ulna.cli.options import Degrees, Loading, load_robot
from ulna.cli.output import printable
from ulna.cli.plugins import FILMS, Film, load_plugins
from ulna.cli.rows import read_motion, read_trajectory
from ulna.cli.targets import Positions, is_name, numbers, q_of
from ulna.collision.world import World
from ulna.engine.progress import progress_bar
from ulna.errors import InputError, needs_extra
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate

Out = Annotated[Path, typer.Argument(metavar="OUT", help="The file: .mp4, .gif, or .png for a single picture.")]
Seconds = Annotated[float | None, typer.Option(help="The duration; by default 30, 10 with --robot, or that of --plan.")]
Size = Annotated[str | None, typer.Option(metavar="WxH", help="In pixels; by default 1280x720, or 640x360 for a .gif.")]
Rate = Annotated[int | None, typer.Option("--fps", help="Pictures per second; by default 30, or 10 for a .gif.")]
At = Annotated[float | None, typer.Option(metavar="SECONDS", help="The time in the demo that a .png shows.")]
RecordedRobot = Annotated[
    str | None,
    typer.Option(
        metavar="ROBOT", help="A robot, instead of the demo; without obstacles, --trajectory and --plan the camera circles it."
    ),
]
Trajectory = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Rows of joint positions, .csv or .npy: the robot moves along them.")
]
PlanFile = Annotated[
    Path | None,
    typer.Option("--plan", metavar="FILE", help="A motion of `ulna plan --csv`, or a message of ROS, shown in real time."),
]
CameraAt = Annotated[
    str | None,
    typer.Option(
        metavar="SIDE",
        help='corner, front, back, left, right or top; or "turn, rise": angles about z from x, and above the horizon.',
    ),
]
Boxes = Annotated[bool, typer.Option("--boxes/--no-boxes", help="Show the shapes of the arm's collision checks.")]
_TURN_AND_RISE = Coordinate("turn", "rad"), Coordinate("rise", "rad")
_SHORTEST = 0.1  # [s], the minimum length of a film
_EXTRA = ("recording", "viewer", "trimesh", "av", "PIL")


@command
def record(
    loading: Loading,
    world: Obstacles,
    *,
    path: Out,
    seconds: Seconds = None,
    size: Size = None,
    rate: Rate = None,
    at: At = None,
    camera: CameraAt = None,
    robot: RecordedRobot = None,
    q: Positions = None,
    degrees: Degrees = False,
    trajectory: Trajectory = None,
    plan: PlanFile = None,
    boxes: Boxes = True,
) -> None:
    """Record the demo as a video, without a display: a box circles the moving arm, and the light shows contacts.

    Example: ulna record out.mp4. A picture of any robot: ulna record arm.png --robot ur5 --q "0, -pi/3, pi/3, 0, pi/2, 0". A
    robot among obstacles: ulna record arm.mp4 --robot panda --scene scene.json --trajectory rows.csv. A planned motion: ulna plan
    panda --xyz "0.4,0.1,0.5" --csv motion.csv, and then ulna record arm.mp4 --robot panda --plan motion.csv.
    """
    of_robot = any(each is not None for each in (robot, q, world, trajectory, plan))
    if sum(each is not None for each in (q, trajectory, plan)) > 1:
        raise InputError("--q, --trajectory, --plan", "give at most one of them: each sets the joint positions")
    if any(value or value is False for value in loading.values()) and not of_robot:
        raise InputError(
            "--base, --tip, --srdf, --no-srdf, --xacro-arg, --package-dir", "require --robot; without it the demo is recorded"
        )
    if camera is not None and not of_robot:
        raise InputError("--camera", "requires --robot; in the demo the camera is fixed")
    if of_robot and at is not None:
        raise InputError("--at", "requires the demo; a robot's picture has no time")
    if path.suffix.lower() == ".png" and (rate is not None or (of_robot and seconds is not None)):
        raise InputError("--seconds, --fps", "require a video; a .png is a single picture, and --seconds the length of the demo")
    with needs_extra(*_EXTRA):
        from ulna.viewer.film.recording import make_form  # noqa: PLC0415 -- needs the extra
    if of_robot:
        film, length = _film_of_robot(load_robot(loading, robot=robot or "panda"), world, q, trajectory, plan, degrees=degrees)
    else:
        film, length = _film(), 30.0
    length = length if seconds is None else seconds
    form = make_form(path, length, None if size is None else _size(size), rate, _camera(camera, degrees=degrees))
    start = time.perf_counter()
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with progress_bar(*columns) as progress:
        task = progress.add_task(path.name, total=form.n_frames)
        film(form, at, boxes=boxes, tell=lambda done: progress.update(task, completed=done))
    typer.echo(printable(_summary(form, time.perf_counter() - start)))


def _film_of_robot(
    robot: Robot, world: World | None, q: str | None, trajectory: Path | None, plan: Path | None, *, degrees: bool
) -> tuple[Film, float]:
    """The film of a robot, and its default length [s], which ``--seconds`` replaces."""
    from ulna.viewer.film import recording  # noqa: PLC0415 -- needs the extra

    still, rows, length = q_of(robot, q=q, degrees=degrees), None, 10.0
    if plan is not None:
        length, rows = read_motion(plan, robot)
    elif trajectory is not None:
        rows = read_trajectory(trajectory, robot)
    elif world is not None:
        rows = still[None]

    def film(form: Any, at: float | None, *, boxes: bool, tell: Callable[[int], object]) -> None:  # noqa: ARG001 -- of the interface
        if rows is None:
            missing = recording.record_robot(form, robot, still, boxes=boxes, tell=tell)
        else:
            missing = recording.record_moving(form, robot, rows, world or World(), boxes=boxes, tell=tell)
        warn_of_missing(missing)

    return film, max(length, _SHORTEST)


def _film() -> Film:
    """The film of a plugin: the demo's, if it is installed."""
    with needs_extra(*_EXTRA):
        films = load_plugins(FILMS)
    if not films:
        raise InputError("--robot", "name a robot to record: the demo, which is recorded without it, is not installed")
    return films[0]


def _size(text: str) -> tuple[int, int]:
    sides = re.fullmatch(r"([0-9]{1,6})[xX]([0-9]{1,6})", text.strip())
    if not sides:
        raise InputError("--size", f"{text!r}; width and height are expected, as in 1280x720")
    return int(sides[1]), int(sides[2])


def _camera(text: str | None, *, degrees: bool) -> str | list[float] | None:
    return text if text is None or is_name(text) else numbers("--camera", text, _TURN_AND_RISE, degrees=degrees)


def _summary(form: Any, seconds: float) -> str:
    pictures = "a picture" if form.is_still else f"{form.n_frames} pictures, {form.n_frames / form.rate:g} s,"
    size, bytes_ = f"{form.size[0]}x{form.size[1]}", form.path.stat().st_size
    return f"{form.path}: {pictures} of {size}, {bytes_ / 1e6:.2f} MB, made in {seconds:.1f} s"
