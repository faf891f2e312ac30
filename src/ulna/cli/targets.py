"""Reads numbers, q or a pose from the command line: ``--q``, ``--from``, ``--xyz``, ``--rpy``, ``--pose``, ``--frame``."""

import math
import re
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray

from ulna.cli.depends import Depends
from ulna.cli.options import AnyRobot, Degrees
from ulna.cli.output import warn
from ulna.description.controllers import CONTROLLERS, controller_named, pose_from
from ulna.description.likely_units import FAR
from ulna.description.pose import pose
from ulna.errors import InputError, UnknownNameError
from ulna.kinematics.groups import JointGroup, state_named
from ulna.robot import Robot
from ulna.robot.coordinates import Coordinate, coordinates_of

XYZ = (Coordinate("x", "m"), Coordinate("y", "m"), Coordinate("z", "m"))
RPY = (Coordinate("roll", "rad"), Coordinate("pitch", "rad"), Coordinate("yaw", "rad"))
WXYZ = tuple(Coordinate(name, "") for name in "wxyz")
ROTVEC = (Coordinate("rx", "rad"), Coordinate("ry", "rad"), Coordinate("rz", "rad"))
BOX = (*XYZ, *RPY, Coordinate("length", "m"), Coordinate("width", "m"), Coordinate("height", "m"))
_DECIMAL = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WITH_PI = re.compile(rf"([+-]?)(?:({_DECIMAL})\*?)?pi(?:/({_DECIMAL}))?")
_WITHOUT_PI = re.compile(rf"[+-]?{_DECIMAL}")


def numbers(option: str, text: str, entries: Sequence[Coordinate], *, degrees: bool = False) -> list[float]:
    """Parse numbers such as "0,-pi/4,0.5 1e-3", one for each entry; with ``degrees``, angles are converted to radians.

    A hint on standard error follows if an angle in radians exceeds a full turn, or a length in meters exceeds any arm's reach.
    """
    found = words(text)
    if len(found) != len(entries):
        names = ", ".join(entry.name for entry in entries[:9]) + (" ..." if len(entries) > 9 else "")
        verb = "is" if len(entries) == 1 else "are"
        raise InputError(option, f"{len(found)} number{'s' * (len(found) != 1)}, but {len(entries)} {verb} expected: {names}")
    values: list[float] = []
    turned: list[str] = []
    for word, entry in zip(found, entries, strict=True):
        is_angle = entry.unit == "rad"
        values.append(_number(option, word, degrees=degrees and is_angle))
        if is_angle and not degrees and abs(values[-1]) > 2 * math.pi and "pi" not in word:
            turned.append(word)
    if turned:
        warn(f"{option}: {turned[0]} rad is more than a turn; with --degrees angles are in degrees")
    units = [entry.unit for entry in entries]
    if any(unit == "m" and abs(value) >= FAR for value, unit in zip(values, units, strict=True)):
        meant = (f"{value / 1e3:g}" if unit == "m" else word for value, unit, word in zip(values, units, found, strict=True))
        warn(f"{option}: lengths are in meters; did you mean {', '.join(meant)}?")
    return values


def is_name(text: str) -> bool:
    """Whether a text begins with a letter and contains no number: "pinch", but neither "pi/2" nor "nan, 0"."""
    return text.strip()[:1].isalpha() and not any(_WITHOUT_PI.fullmatch(w) or _WITH_PI.fullmatch(w) for w in words(text))


def words(text: str) -> list[str]:
    """Split a text at commas or spaces."""
    return re.split(r"\s*,\s*|\s+", text.strip()) if text.strip() else []


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


Array = NDArray[np.float64]
HOME = "home"

Positions = Annotated[
    str | None,
    typer.Option(
        "--q", metavar="NUMBERS", help='Joint positions, as in "0,-pi/4,0.5 1e-3", or a state of the SRDF; by default home.'
    ),
]
Start = Annotated[
    str | None,
    typer.Option("--from", metavar="NUMBERS", help="Joint positions to start from, or a state of the SRDF, or home."),
]
RollPitchYaw = Annotated[str | None, typer.Option(metavar="R,P,Y", help="Roll, pitch, yaw; by default the orientation at home.")]
Quaternion = Annotated[str | None, typer.Option(metavar="W,X,Y,Z", help="The orientation as a quaternion instead.")]


RotationVector = Annotated[
    str | None, typer.Option(metavar="RX,RY,RZ", help="Or as a rotation vector, as Universal Robots state it.")
]
WholePose = Annotated[
    str | None,
    typer.Option(
        "--pose",
        metavar="NUMBERS",
        help="Position and orientation as --controller states them; else x, y, z, roll, pitch, yaw.",
    ),
]
ControllerName = Annotated[
    str | None,
    typer.Option(
        "--controller", metavar="NAME", help=f"The controller whose units and angles poses have: {', '.join(CONTROLLERS)}."
    ),
]
FrameText = Annotated[
    str | None,
    typer.Option(
        "--frame",
        metavar="FRAME",
        help='The frame of poses: a fixed link, or its "x,y,z,roll,pitch,yaw".',
    ),
]


def q_of(robot: AnyRobot, *, q: Positions = None, degrees: Degrees = False) -> Array:
    """The q of ``--q`` [rad or m], shape (n_dof,); home without it."""
    return robot.home if q is None else positions("--q", q, robot, degrees=degrees)


Q = Annotated[Array, Depends(q_of)]
BeginQ = Annotated[
    str | None,
    typer.Option(
        "--q",
        metavar="NUMBERS",
        help='Initial joint positions, as in "0,-pi/4,0.5 1e-3", or a state of the SRDF; by default bent and collision-free.',
    ),
]


def beginning_of(robot: AnyRobot, *, q: BeginQ = None, degrees: Degrees = False) -> Array | None:
    """The q of ``--q`` [rad or m], shape (n_dof,); None without it, so that the page chooses one."""
    return None if q is None else positions("--q", q, robot, degrees=degrees)


BeginningQ = Annotated[Array | None, Depends(beginning_of)]


def start_of(robot: AnyRobot, *, start: Start = None, degrees: Degrees = False) -> Array | None:
    """The q of ``--from`` [rad or m], shape (n_dof,); None without it."""
    return None if start is None else positions("--from", start, robot, degrees=degrees)


StartQ = Annotated[Array | None, Depends(start_of)]


def orientation_of(
    *, rpy: RollPitchYaw = None, wxyz: Quaternion = None, rotvec: RotationVector = None, degrees: Degrees = False
) -> Array | None:
    """The orientation of ``--rpy``, ``--wxyz`` or ``--rotvec`` as a pose at the origin, shape (4, 4); None without them."""
    given = [name for name, text in (("--rpy", rpy), ("--wxyz", wxyz), ("--rotvec", rotvec)) if text is not None]
    if len(given) > 1:
        raise InputError(", ".join(given), f"give one of them, not {'both' if len(given) == 2 else 'all'}")
    if wxyz is not None:
        return pose(wxyz=numbers("--wxyz", wxyz, WXYZ))
    if rotvec is not None:
        return pose(rotvec=numbers("--rotvec", rotvec, ROTVEC, degrees=degrees))
    return None if rpy is None else pose(rpy=numbers("--rpy", rpy, RPY, degrees=degrees))


Orientation = Annotated[Array | None, Depends(orientation_of)]


class Target(NamedTuple):
    """A target pose of a link, as the command line states it.

    Attributes:
        whole: The pose of ``--pose``, shape (4, 4); None without it.
        orientation: The orientation of ``--rpy``, ``--wxyz`` or ``--rotvec``, shape (4, 4); None without them.
        frame: The frame of the pose: a link, or T_base_frame, shape (4, 4); None for the base.
    """

    whole: Array | None
    orientation: Array | None
    frame: str | Array | None

    @property
    def is_given(self) -> bool:
        """Whether any of its options is given."""
        return self.whole is not None or self.orientation is not None or self.frame is not None


def frame_of(*, frame: FrameText = None, degrees: Degrees = False) -> str | Array | None:
    """The frame of ``--frame``: the name of a link, or T_base_frame, shape (4, 4); None without it."""
    if frame is None or is_name(frame):
        return frame
    xyz_rpy = numbers("--frame", frame, (*XYZ, *RPY), degrees=degrees)
    return pose(xyz_rpy[:3], xyz_rpy[3:])


StatedIn = Annotated[str | Array | None, Depends(frame_of)]


def target_of(
    orientation: Orientation,
    frame: StatedIn,
    *,
    whole: WholePose = None,
    controller: ControllerName = None,
    degrees: Degrees = False,
) -> Target:
    """The target of ``--pose``, the options of an orientation, and ``--frame``."""
    if whole is None:
        if controller is not None:
            raise InputError("--controller", "requires --pose")
        return Target(None, orientation, frame)
    if orientation is not None:
        raise InputError("--pose", "already contains an orientation; give no other")
    if controller is None:
        xyz_rpy = numbers("--pose", whole, (*XYZ, *RPY), degrees=degrees)
        return Target(pose(xyz_rpy[:3], xyz_rpy[3:]), None, frame)
    said = controller_named(controller, "--controller")
    values = numbers("--pose", whole, [Coordinate(label, "") for label in said.labels])
    return Target(pose_from(values, said.name), None, frame)


TargetPose = Annotated[Target, Depends(target_of)]


def target_pose(robot: Robot, link: str, xyz: str | None, target: Target) -> Array:
    """The pose of ``--pose`` or ``--xyz`` in its frame, shape (4, 4).

    With ``--xyz`` alone the link keeps its orientation at home.
    """
    if (target.whole is None) == (xyz is None):
        raise InputError("--xyz, --pose", "one of them is expected")
    if target.whole is not None:
        return target.whole
    at_home = robot.forward_kinematics(robot.home, link=link, frame=target.frame)
    T = at_home if target.orientation is None else target.orientation
    T[:3, 3] = numbers("--xyz", str(xyz), XYZ)
    return T


def positions(option: str, text: str, robot: Robot, group: JointGroup | None = None, *, degrees: bool) -> Array:
    """The q [rad or m], shape (n_dof,), of an option: numbers, a state of the SRDF, or ``home``."""
    state = state_of(text, robot, group)
    if state is not None:
        return robot.named_configurations[state]
    return robot.home if text == HOME else np.array(numbers(option, text, coordinates_of(robot), degrees=degrees))


def state_of(text: str, robot: Robot, group: JointGroup | None) -> str | None:
    """The key of the SRDF state that a text names; None if the text is ``home`` or numbers."""
    try:
        return state_named(text, robot.srdf.states, group).key
    except UnknownNameError:
        if is_name(text) and text != HOME:
            raise
    return None
