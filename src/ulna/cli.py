"""The command ``ulna``: each subcommand reads its options, calls the library once or twice and shows the answer.

Exit status: 0 done; 1 the answer is no (not solved, collision, a check that failed); 2 the question is wrong; 130 Ctrl-C; 141
nobody reads the output any more. Errors are one line on standard error.
"""

import io
import math
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from typer.core import TyperGroup

import ulna
from ulna import answers, tables
from ulna.answers import Entry
from ulna.checks import run_checks
from ulna.demo import Demo
from ulna.errors import InputError, UlnaError


class _Commands(TyperGroup):
    """The subcommands, with errors of the library as one line and a closed pipe as the quiet end."""

    def invoke(self, ctx):
        try:
            return super().invoke(ctx)
        except UlnaError as error:
            typer.echo(f"ulna: {' '.join(str(error).split())}", err=True)
            raise typer.Exit(2) from None
        except OSError as error:  # of the output: files that cannot be read are an UlnaError
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more as it ends
            if isinstance(error, BrokenPipeError):
                raise typer.Exit(141) from None
            typer.echo(f"ulna: {error.strerror or error}", err=True)
            raise typer.Exit(2) from None


app = typer.Typer(
    cls=_Commands,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

RobotName = Annotated[str, typer.Argument(metavar="ROBOT", help="A bundled name, or the path of a .urdf or .xacro file.")]
XacroArgs = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="KEY:=VALUE", help="An argument of a xacro file; repeatable.")
]
PackageDirs = Annotated[
    list[Path] | None, typer.Option("--package-dir", metavar="FOLDER", help="Where ROS packages lie; repeatable.")
]
Link = Annotated[str | None, typer.Option(metavar="NAME", help="The link; the tip unless given.")]
Positions = Annotated[
    str | None, typer.Option("--q", metavar="NUMBERS", help='Joint positions, as in "0,-pi/4,0.5 1e-3"; home unless given.')
]
Degrees = Annotated[bool, typer.Option("--degrees", help="All angles given are degrees, not radians.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON object instead of tables: metres and radians, infinity is null.")]

XYZ = (Entry("x", "m"), Entry("y", "m"), Entry("z", "m"))
RPY = (Entry("roll", "rad"), Entry("pitch", "rad"), Entry("yaw", "rad"))
WXYZ = tuple(Entry(name, "") for name in "wxyz")
BOX = (*XYZ, *RPY, Entry("length", "m"), Entry("width", "m"), Entry("height", "m"))


def _version(value: bool) -> None:  # noqa: FBT001 -- typer calls it so
    if value:
        typer.echo(f"ulna {ulna.__version__}")
        raise typer.Exit


Version = Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="The version.")]


@app.callback()
def main(*, version: Version = False) -> None:  # noqa: ARG001 -- its callback has done it
    """Robot-arm kinematics and collision checking.

    Every command says more: ulna fk --help.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name that the terminal cannot write is no reason to fail


@app.command(epilog=f"JSON: {answers.INFO_KEYS}")
def info(
    robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None, as_json: Json = False
) -> None:
    """What a robot is: its joints with their limits, its links, its collision shapes."""
    tables.show(answers.info_data(_load(robot, xacro_arg, package_dir)), None if as_json else tables.info_view)


@app.command(epilog=f"JSON: {answers.POSE_KEYS}")
def fk(
    robot: RobotName = "panda",
    *,
    q: Positions = None,
    link: Link = None,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Forward kinematics: where a link is.

    As in: ulna fk --q "0,-pi/4,0,-3pi/4,0,pi/2,pi/4".
    """
    arm = _load(robot, xacro_arg, package_dir)
    at = _positions("--q", q, arm, degrees=degrees)
    T = arm.forward_kinematics(at, link)
    tables.show(answers.pose_data(arm, at, link or str(arm.tip), T), None if as_json else tables.pose_view)


@app.command(epilog=f"JSON: {answers.JACOBIAN_KEYS}")
def jacobian(
    robot: RobotName = "panda",
    *,
    q: Positions = None,
    link: Link = None,
    expressed_in: Annotated[str | None, typer.Option(metavar="FRAME", help="base, link or spatial; base unless given.")] = None,
    analytical: Annotated[bool, typer.Option("--analytical", help="Rates of x, y, z, roll, pitch, yaw instead.")] = False,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """The Jacobian: how fast a link moves for a unit rate of each joint.

    Rows are linear first, then angular: metres and radians per second.
    """
    arm = _load(robot, xacro_arg, package_dir)
    at = _positions("--q", q, arm, degrees=degrees)
    if analytical and expressed_in is not None:
        raise InputError("--expressed-in", "goes with the geometric Jacobian, not with --analytical")
    frame = None if analytical else "base" if expressed_in is None else expressed_in
    J = arm.analytical_jacobian(at, link) if frame is None else arm.jacobian(at, link, frame)
    tables.show(answers.jacobian_data(arm, at, link or str(arm.tip), J, frame), None if as_json else tables.jacobian_view)


@app.command(epilog=f"JSON: {answers.IK_KEYS}")
def ik(
    robot: RobotName = "panda",
    *,
    xyz: Annotated[str, typer.Option(metavar="X,Y,Z", help="The position to reach, in metres.")],
    rpy: Annotated[
        str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch, yaw; the orientation at home unless given.")
    ] = None,
    wxyz: Annotated[str | None, typer.Option(metavar="W,X,Y,Z", help="The orientation as a quaternion instead.")] = None,
    q_seed: Annotated[str | None, typer.Option(metavar="NUMBERS", help="Joint positions to start from.")] = None,
    link: Link = None,
    method: Annotated[
        str, typer.Option(metavar="NAME", help="levenberg_marquardt or jacobian_transpose.")
    ] = "levenberg_marquardt",
    seed: Annotated[int, typer.Option(min=0, help="Chooses the random starts.")] = 0,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Inverse kinematics: joint positions that bring a link to a pose.

    As in: ulna ik --xyz "0.4,0,0.5" --rpy "pi,0,0".
    Exit status 0 if solved, 1 if not. Without --rpy or --wxyz the link keeps the orientation that it has at home.
    """
    arm = _load(robot, xacro_arg, package_dir)
    T, orientation = _target(arm, link, xyz, rpy, wxyz, degrees=degrees)
    start = None if q_seed is None else _positions("--q-seed", q_seed, arm, degrees=degrees)
    result = arm.inverse_kinematics(T, start, link, method, seed)
    tables.show(answers.ik_data(arm, link or str(arm.tip), T, orientation, method, result), None if as_json else tables.ik_view)
    raise typer.Exit(0 if result.success else 1)


@app.command(epilog=f"JSON: {answers.REPORT_KEYS}")
def check(
    robot: RobotName = "panda",
    *,
    box: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBERS", help='A box: "x, y, z, roll, pitch, yaw, length, width, height"; repeatable: box 1, box 2 ...'
        ),
    ] = None,
    q: Positions = None,
    itself: Annotated[bool, typer.Option("--self/--no-self", help="Check the robot's links against each other too.")] = True,
    within: Annotated[float, typer.Option(min=0, metavar="METRES", help="Show pairs too that are so near.")] = 0.0,
    degrees: Degrees = False,
    xacro_arg: XacroArgs = None,
    package_dir: PackageDirs = None,
    as_json: Json = False,
) -> None:
    """Whether the robot touches itself or boxes, how deep and where, and how far it is from them.

    As in: ulna check --box "0.5,0,0.21,0,0,0,0.15,0.09,0.126". Exit status 0 if it is free, 1 if not.
    """
    arm = _load(robot, xacro_arg, package_dir)
    world = ulna.World()
    for k, text in enumerate(box or (), start=1):
        *place, length, width, height = _numbers("--box", text, BOX, degrees=degrees)
        world.add(f"box {k}", ulna.Box((length, width, height)), ulna.pose(place[:3], place[3:]))
    at = _positions("--q", q, arm, degrees=degrees)
    report = arm.check_collision(at, world, itself, max_distance=within)
    distance = arm.signed_distance(at, world, itself)
    tables.show(answers.report_data(arm, at, report, distance), None if as_json else tables.report_view)
    raise typer.Exit(1 if report.in_collision else 0)


@app.command()
def urdf(robot: RobotName = "panda", *, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None) -> None:
    """Print the robot's URDF: of a xacro file, what it expands to."""
    text = _load(robot, xacro_arg, package_dir).to_urdf()
    typer.echo(text.encode(), nl=False)


@app.command(epilog=f"JSON: {answers.CHECKS_KEYS}")
def demo(
    *,
    check: Annotated[bool, typer.Option("--check", help="Stop after the checks.")] = False,
    host: Annotated[str, typer.Option(help="Where to serve the view.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Its port.")] = 8080,
    no_open: Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")] = False,
    as_json: Json = False,
) -> None:
    """The assignment: its checks, run on this machine, and then the arm, the box and the light in the browser.

    Exit status 1 if a check fails; then nothing is served.
    """
    if as_json and not check:
        raise InputError("--json", "goes with --check; the view is no JSON")
    if not tables.show_checks(run_checks(), as_json=as_json):
        raise typer.Exit(1)
    if not check:
        _serve(host, port, open_browser=not no_open)


def _serve(host: str, port: int, *, open_browser: bool) -> None:
    try:
        from ulna.viewer.app import serve  # noqa: PLC0415 -- the one layer that needs the extra
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in ("viser", "trimesh"):
            raise
        raise UlnaError("the view needs the viewer extra: pip install 'ulna[viewer]'") from None
    serve(demo=Demo(), host=host, port=port, open_browser=open_browser)


# ---- what options mean ------------------------------------------------------------------------------------------------


def _load(robot: str, xacro_arg: Sequence[str] | None, package_dir: Sequence[Path] | None) -> ulna.Robot:
    arguments = {}
    for text in xacro_arg or ():
        key, separator, value = text.partition(":=")
        if not (separator and key):
            raise InputError("--xacro-arg", f"{text!r}; key:=value is expected")
        arguments[key] = value
    return ulna.load(robot, xacro_args=arguments, package_dirs=package_dir or ())


def _positions(option: str, text: str | None, robot: ulna.Robot, *, degrees: bool) -> NDArray[np.float64]:
    if text is None:
        return robot.home
    return np.array(_numbers(option, text, answers.entries_of_q(robot), degrees=degrees))


def _target(
    robot: ulna.Robot, link: str | None, xyz: str, rpy: str | None, wxyz: str | None, *, degrees: bool
) -> tuple[NDArray[np.float64], str]:
    """The pose to reach, and whether its orientation was "given" or is that of "home"."""
    if rpy is not None and wxyz is not None:
        raise InputError("--rpy, --wxyz", "give one of them, not both")
    position = _numbers("--xyz", xyz, XYZ)
    if rpy is not None:
        return ulna.pose(position, _numbers("--rpy", rpy, RPY, degrees=degrees)), "given"
    if wxyz is not None:
        return ulna.pose(position, wxyz=_numbers("--wxyz", wxyz, WXYZ)), "given"
    T = robot.forward_kinematics(robot.home, link)
    T[:3, 3] = position
    return T, "home"


_DECIMAL = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WITH_PI = re.compile(rf"([+-]?)(?:({_DECIMAL})\*?)?pi(?:/({_DECIMAL}))?")
_WITHOUT_PI = re.compile(rf"[+-]?{_DECIMAL}")


def _numbers(option: str, text: str, entries: Sequence[Entry], *, degrees: bool = False) -> list[float]:
    """The numbers in "0,-pi/4,0.5 1e-3", one for each entry; with ``degrees``, those of angles are turned into radians."""
    words = re.split(r"\s*,\s*|\s+", text.strip()) if text.strip() else []
    if len(words) != len(entries):
        names = ", ".join(entry.name for entry in entries[:9]) + (" ..." if len(entries) > 9 else "")
        raise InputError(option, f"{len(words)} number{'s' * (len(words) != 1)}, but {len(entries)} are expected: {names}")
    return [_number(option, word, degrees=degrees and entry.unit == "rad") for word, entry in zip(words, entries, strict=True)]


def _number(option: str, word: str, *, degrees: bool) -> float:
    value = math.nan
    if _WITHOUT_PI.fullmatch(word):
        value = math.radians(float(word)) if degrees else float(word)
    elif match := _WITH_PI.fullmatch(word):
        if degrees:
            raise InputError(option, f"{word!r} is in radians, but --degrees is given")
        sign, factor, divisor = match.groups()
        value = float(f"{sign}{factor or 1}") * math.pi / (float(divisor or 1) or math.nan)
    if not math.isfinite(value):
        raise InputError(option, f"{word!r} is not a number; numbers are written as 0.5, 1e-3, pi/2 or -3pi/4")
    return value
