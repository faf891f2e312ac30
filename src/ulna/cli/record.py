"""``ulna record``: videos and pictures without a display."""

import re
import time
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ulna.cli.options import Degrees, PackageDirs, Positions, XacroArgs, as_options, load_robot, positions
from ulna.errors import InputError, needs_extra

_OPTIONS = {"path": "OUT", "seconds": "--seconds", "size": "--size", "rate": "--fps", "at": "--at"}


def record(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The file: .mp4, .gif, or .png for a single picture.")],
    *,
    seconds: Annotated[float | None, typer.Option(help="How long it is; 30, and 10 of a robot that stands.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="In pixels; 1280x720, and 640x360 of a .gif.")] = None,
    fps: Annotated[int | None, typer.Option(help="Pictures a second; 30, and 10 of a .gif.")] = None,
    at: Annotated[float | None, typer.Option(metavar="SECONDS", help="Which moment of the demo a .png shows.")] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="ROBOT", help="A robot, instead of the demo; the camera goes round it.")
    ] = None,
    q: Positions = None,
    degrees: Degrees = False,
    boxes: Annotated[bool, typer.Option("--boxes/--no-boxes", help="Show the boxes that stand for the arm.")] = True,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
) -> None:
    """Record the demo as a video, with no display: the box goes round the moving arm, and the light says what it touches.

    As in: ulna record out.mp4. A picture of any robot: ulna record arm.png --robot ur5 --q "0, -pi/3, pi/3, 0, pi/2, 0".
    """
    of_robot = robot is not None or q is not None
    if not of_robot and (xacro_arg or package_dir):
        raise InputError("--xacro-arg, --package-dir", "go with --robot; without it the demo is recorded")
    if of_robot and at is not None:
        raise InputError("--at", "goes with the demo; a robot that stands has no moments")
    if degrees and q is None:
        raise InputError("--degrees", "goes with --q")
    if out.suffix.lower() == ".png" and (fps is not None or (of_robot and seconds is not None)):
        raise InputError(
            "--seconds, --fps", "go with a video; a .png is a single picture, and --seconds the length of the demo's story"
        )
    recorder = _recorder()
    seconds = (10.0 if of_robot else 30.0) if seconds is None else seconds
    with as_options(_OPTIONS):
        form = recorder.make_form(out, seconds, None if size is None else _size(size), fps)
    start = time.perf_counter()
    missing: tuple[str, ...] = ()
    with as_options(_OPTIONS), _progress() as progress:
        task = progress.add_task(out.name, total=form.n_frames)

        def tell(done: int) -> None:
            progress.update(task, completed=done)

        if of_robot:
            arm = load_robot(robot or "panda", xacro_arg, package_dir)
            missing = recorder.record_robot(form, arm, positions("--q", q, arm, degrees=degrees), boxes=boxes, tell=tell)
        else:
            recorder.record_demo(form, at, boxes=boxes, tell=tell)
    for mesh in missing:
        typer.echo(f"not shown: {mesh}", err=True)
    typer.echo(_summary(form, time.perf_counter() - start))


def _recorder() -> ModuleType:
    with needs_extra("recording", "viewer", "trimesh", "av", "PIL"):
        from ulna.viewer.film import record as recorder  # noqa: PLC0415 -- the one layer that needs the extra
    return recorder


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
