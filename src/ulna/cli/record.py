"""``ulna record``: videos and pictures, with no display."""

import re
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ulna.cli.options import Degrees, PackageDirs, Positions, Scene, XacroArgs, as_options, load_robot, positions, world_of
from ulna.cli.output import printable, warn
from ulna.cli.plugins import FILMS, load_plugins
from ulna.cli.trajectory import read_motion, read_trajectory
from ulna.errors import InputError, needs_extra

Out = Annotated[Path, typer.Argument(metavar="OUT", help="The file: .mp4, .gif, or .png for a single picture.")]
Seconds = Annotated[float | None, typer.Option(help="How long it is; 30, or 10 with --robot, or as --plan.")]
Size = Annotated[str | None, typer.Option(metavar="WxH", help="In pixels; 1280x720, or 640x360 of a .gif.")]
Rate = Annotated[int | None, typer.Option(help="Pictures a second; 30, or 10 of a .gif.")]
At = Annotated[float | None, typer.Option(metavar="SECONDS", help="Which moment of the demo a .png shows.")]
RecordedRobot = Annotated[
    str | None,
    typer.Option(
        metavar="ROBOT", help="A robot, instead of the demo; without --scene, --trajectory and --plan the camera goes round it."
    ),
]
Trajectory = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Rows of joint positions, .csv or .npy: the robot moves along them.")
]
PlanFile = Annotated[
    Path | None,
    typer.Option("--plan", metavar="FILE", help="A motion that `ulna plan --csv` wrote, shown in its time."),
]
Boxes = Annotated[bool, typer.Option("--boxes/--no-boxes", help="Show the boxes that collisions of the arm are checked with.")]
_OPTIONS = {"path": "OUT", "seconds": "--seconds", "size": "--size", "rate": "--fps", "at": "--at"}
_SHORTEST = 0.1  # [s] of a motion that does not move
_EXTRA = ("recording", "viewer", "trimesh", "av", "PIL")


class Film(Protocol):
    """What a package adds in the group ``ulna.films``: it records into the file of a ``viewer.film.record.Form``."""

    def __call__(self, form: Any, at: float | None, *, boxes: bool, tell: Callable[[int], object]) -> None:
        """Record. ``at``: the moment [s] of a single picture; ``tell`` is called with the number of pictures done so far."""


def record(
    out: Out,
    *,
    seconds: Seconds = None,
    size: Size = None,
    fps: Rate = None,
    at: At = None,
    robot: RecordedRobot = None,
    q: Positions = None,
    degrees: Degrees = False,
    scene: Scene = None,
    trajectory: Trajectory = None,
    plan: PlanFile = None,
    boxes: Boxes = True,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
) -> None:
    """Record the demo as a video, with no display: the box goes round the moving arm, and the light says what it touches.

    As in: ulna record out.mp4. A picture of any robot: ulna record arm.png --robot ur5 --q "0, -pi/3, pi/3, 0, pi/2, 0".
    A robot among obstacles: ulna record arm.mp4 --robot panda --scene scene.json --trajectory rows.csv. A motion that is planned:
    ulna plan panda --xyz "0.4,0.1,0.5" --csv motion.csv, and then ulna record arm.mp4 --robot panda --plan motion.csv.
    """
    of_robot = any(each is not None for each in (robot, q, scene, trajectory, plan))
    if sum(each is not None for each in (q, trajectory, plan)) > 1:
        raise InputError("--q, --trajectory, --plan", "at most one of them is expected: each has the joint positions")
    _refuse_what_does_not_go_together(out, (seconds, fps, at), of_robot=of_robot, of_files=bool(xacro_arg or package_dir))
    if degrees and q is None:
        raise InputError("--degrees", "goes with --q")
    recorder = _recorder()
    film = None if of_robot else _film()
    arm = load_robot(robot or "panda", xacro_arg, package_dir) if of_robot else None
    motion = None
    if arm is not None and plan is not None:
        duration, motion = read_motion(plan, arm)
        seconds = seconds or max(duration, _SHORTEST)
    seconds = (10.0 if of_robot else 30.0) if seconds is None else seconds
    with as_options(_OPTIONS):
        form = recorder.make_form(out, seconds, None if size is None else _size(size), fps)
    start = time.perf_counter()
    missing: tuple[str, ...] = ()
    with as_options(_OPTIONS), _progress() as progress:
        task = progress.add_task(out.name, total=form.n_frames)

        def tell(done: int) -> None:
            progress.update(task, completed=done)

        if arm is not None:
            still = positions("--q", q, arm, degrees=degrees)
            if scene is None and trajectory is None and motion is None:
                missing = recorder.record_robot(form, arm, still, boxes=boxes, tell=tell)
            else:
                path = motion if motion is not None else still[None] if trajectory is None else read_trajectory(trajectory, arm)
                missing = _moving().record_moving(form, arm, path, world_of(scene), boxes=boxes, tell=tell)
        elif film is not None:
            film(form, at, boxes=boxes, tell=tell)
    for mesh in missing:
        warn(f"not shown: {mesh}")
    typer.echo(printable(_summary(form, time.perf_counter() - start)))


def _refuse_what_does_not_go_together(out: Path, times: tuple, *, of_robot: bool, of_files: bool) -> None:
    seconds, fps, at = times
    if not of_robot and of_files:
        raise InputError("--xacro-arg, --package-dir", "go with --robot; without it the demo is recorded")
    if of_robot and at is not None:
        raise InputError("--at", "goes with the demo; a robot that does not move has no points in time")
    if out.suffix.lower() == ".png" and (fps is not None or (of_robot and seconds is not None)):
        raise InputError("--seconds, --fps", "go with a video; a .png is a single picture, and --seconds the length of the demo")


def _recorder() -> ModuleType:
    with needs_extra(*_EXTRA):
        from ulna.viewer.film import record as recorder  # noqa: PLC0415 -- needs the extra
    return recorder


def _moving() -> ModuleType:
    with needs_extra(*_EXTRA):
        from ulna.viewer.film import moving  # noqa: PLC0415 -- needs the extra
    return moving


def _film() -> Film:
    """The film of a plugin: the demo's, if it is installed.

    Raises:
        InputError: There is none, so a robot must be named.
    """
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


def _progress() -> Progress:
    """A bar on a terminal, nothing elsewhere."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


def _summary(form: Any, seconds: float) -> str:
    pictures = "a picture" if form.is_still else f"{form.n_frames} pictures, {form.n_frames / form.rate:g} s,"
    size, bytes_ = f"{form.size[0]}x{form.size[1]}", form.path.stat().st_size
    return f"{form.path}: {pictures} of {size}, {bytes_ / 1e6:.2f} MB, made in {seconds:.1f} s"
