"""Declares options that several commands share: the robot and a part of it, a link, a seed, a page."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from ulna.cli.depends import Depends, Json, as_options
from ulna.cli.output import warn
from ulna.errors import DescriptionWarning, InputError
from ulna.planning.hand import HandLimits
from ulna.robot import Robot, load
from ulna.robot.hand_link import hand_link


def _names_that_begin(incomplete: str) -> list[str]:
    """The names of installed robots with a prefix, for shell completion."""
    from ulna.description.names.by_name import known_robots  # noqa: PLC0415 -- only shell completion needs it

    names = [name for robot in known_robots() if robot.installed for name in (robot.name, *robot.also)]
    return [name for name in names if name.startswith(incomplete)]


RobotName = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A name of `ulna list`, or the path of a .urdf, .xacro or .sdf file.",
        autocompletion=_names_that_begin,
    ),
]
XacroArgs = Annotated[
    list[str] | None, typer.Option("--xacro-arg", metavar="KEY:=VALUE", help="An argument of a xacro file; repeatable.")
]
PackageDirs = Annotated[
    list[Path] | None, typer.Option("--package-dir", metavar="FOLDER", help="A folder that contains ROS packages; repeatable.")
]
Base = Annotated[str | None, typer.Option(metavar="LINK", help="The base link; by default the root.")]
Tip = Annotated[str | None, typer.Option(metavar="LINK", help="The tip link: only the chain to it is loaded.")]
SrdfFile = Annotated[
    Path | None,
    typer.Option("--srdf", metavar="FILE", help="A semantic description: groups, states, pairs of links that may touch."),
]
NoSrdf = Annotated[bool, typer.Option("--no-srdf", help="Ignore an SRDF next to the URDF.")]
LinkName = Annotated[
    str | None, typer.Option(metavar="NAME", help="The link; by default the tip, or the hand if there are several tips.")
]
Degrees = Annotated[bool, typer.Option("--degrees", help="All angles are in degrees, not radians.")]
Seed = Annotated[int, typer.Option(help="Chooses the random samples: the same number gives the same result.")]
HandSpeed = Annotated[float | None, typer.Option("--hand-speed", metavar="NUMBER", help="Maximum speed of the hand [m/s].")]
HandAcceleration = Annotated[
    float | None, typer.Option("--hand-acceleration", metavar="NUMBER", help="Maximum acceleration of the hand [m/s^2].")
]
Jerk = Annotated[float | None, typer.Option(metavar="NUMBER", help="Maximum jerk of every joint [rad/s^3 or m/s^3].")]
TaskName = Annotated[str, typer.Option(metavar="NAME", help="pose, position, or pointing: the z axis alone.")]
Host = Annotated[str, typer.Option(help="The address to listen on; any but 127.0.0.1, localhost and ::1 lets other machines in.")]
Port = Annotated[int, typer.Option(min=0, max=65535, help="The port; 0 selects a free one.")]
NoOpen = Annotated[bool, typer.Option("--no-open", help="Do not open a browser.")]


def sources(*, xacro_arg: XacroArgs = None, package_dir: PackageDirs = None) -> dict[str, Any]:
    """The arguments for reading a description: ``xacro_args`` from key:=value, and ``package_dirs``."""
    arguments = {}
    for text in xacro_arg or ():
        key, separator, value = text.partition(":=")
        if not (separator and key):
            raise InputError("--xacro-arg", f"{text!r}; key:=value is expected")
        arguments[key] = value
    return {"xacro_args": arguments, "package_dirs": package_dir or ()}


Sources = Annotated[dict[str, Any], Depends(sources)]


def loading(
    sources: Sources, *, base: Base = None, tip: Tip = None, srdf: SrdfFile = None, no_srdf: NoSrdf = False
) -> dict[str, Any]:
    """The arguments of ``ulna.load``: how a robot is loaded, and which part of it."""
    if no_srdf and srdf is not None:
        raise InputError("--srdf, --no-srdf", "give only one of them")
    return {**sources, "base": base, "tip": tip, "srdf": False if no_srdf else srdf}


Loading = Annotated[dict[str, Any], Depends(loading)]


@contextmanager
def warnings_printed() -> Iterator[None]:
    """Within the block, warnings about files become lines on standard error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DescriptionWarning)
        yield
    for warning in caught:
        warn(str(warning.message))


def load_robot(loading: Loading, *, robot: RobotName = "panda") -> Robot:
    """Load the robot of a name or a file; warnings about unknown names in an SRDF go to standard error."""
    with warnings_printed():
        return load(robot, **loading)


AnyRobot = Annotated[Robot, Depends(load_robot)]


def link_or_hand(robot: AnyRobot, loading: Loading, *, link: LinkName = None, as_json: Json = False) -> str:
    """The link of ``named_or_hand``; raises an error if it is not below ``--base``."""
    if link is not None and loading["base"] is not None and link not in robot.link_names:
        advice = f"--frame {robot.base} states poses in {robot.base!r} of the whole robot"
        raise InputError("--base, --link", f"{link!r} is not below {robot.base!r}, or is not a link; {advice}")
    return named_or_hand(robot, link=link, as_json=as_json)


def hand_of(robot: Robot, speed: float | None, acceleration: float | None, link: str | None = None) -> HandLimits | None:
    """The limits of a link, or of the hand, from the options; None without them."""
    if speed is None and acceleration is None:
        return None
    with as_options({"speed": "--hand-speed", "acceleration": "--hand-acceleration"}):
        return HandLimits(speed, acceleration, link=link or robot.tree.tip or hand_link(robot))


def named_or_hand(robot: Robot, *, link: str | None, as_json: bool) -> str:
    """The named link, else the tip, else the hand, whose name is printed on standard error unless JSON contains it."""
    known = robot.tip if link is None else link
    if known is not None:
        return known
    hand = hand_link(robot)
    if not as_json:
        warn(f"{robot.name} has {len(robot.tree.leaves)} tips; using {hand}, --link selects another")
    return hand


Link = Annotated[str, Depends(link_or_hand)]


class PageOptions(NamedTuple):
    """The address of a page, and whether a browser opens it."""

    host: str = "127.0.0.1"
    port: int = 8080
    open_browser: bool = True


_HERE = PageOptions()


def page_options(*, host: Host = _HERE.host, port: Port = _HERE.port, no_open: NoOpen = False) -> PageOptions:
    """Collect the options of a page."""
    return PageOptions(host, port, not no_open)


OnPage = Annotated[PageOptions, Depends(page_options)]
