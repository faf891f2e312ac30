"""Reads a motion from a ROS message, a MoveIt plan (YAML, JSON) or a table with times (CSV, .npy)."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.description.columns import TIMES, Found, Quantity, Row, rate_kind, words_of
from ulna.description.joint_points import JointPoints, is_message, read_joint_points
from ulna.description.number_rows import read_numbers, refuse_infinite
from ulna.errors import DescriptionError, DescriptionWarning, InputError, cited, listed
from ulna.kinematics.positions import as_configuration, look_for_degrees, refuse_out_of_range
from ulna.kinematics.tree import entry_names
from ulna.planning.boundary_velocities import Ends
from ulna.planning.motion import Motion
from ulna.planning.motion_limits import described_limits
from ulna.planning.positions import PositionLimits
from ulna.planning.space import make_space
from ulna.planning.spline_trajectory import interpolate_points
from ulna.planning.trajectory import Trajectory, trajectory_at_rest
from ulna.robot.joint_columns import joint_columns

if TYPE_CHECKING:
    from ulna.robot.robot import Robot

Array = NDArray[np.float64]
_MAX_SECONDS = 7200  # maximum duration of a motion
_STILL = 1e-9  # [rad/s or m/s]: smaller velocities at the ends are rounding
_ORDERS = {"velocity": r"velocity|vel|speed|qd|dq|qdot", "acceleration": r"acceleration|acc|accel|qdd|ddq|qddot"}


def motion_of_file(robot: Robot, path: str | Path, others: ArrayLike | None = None, option: str = "path") -> Trajectory:
    """Read the motion of a file; see ``Trajectory.from_file``. option: the name of the path argument in errors."""
    if not isinstance(path, (str, Path)):
        raise InputError(option, f"{cited(path)}; the name of a file is expected")
    path, tree = Path(path), robot.tree
    rest = None if others is None else as_configuration(others, tree, "others")
    read, where, what = (_read_message, "", "point") if is_message(path) else (_read_table, option, "row")
    points = read(robot, path, rest, option)
    wrong = np.flatnonzero(np.diff(points.times) <= 0.0)
    if len(wrong):
        raise _content_error(f"{what} {wrong[0] + 1} is not later than the {what} before", path, where)
    if points.times[-1] - points.times[0] > _MAX_SECONDS:
        lasts = f"it lasts {points.times[-1] - points.times[0]:g} s; up to {_MAX_SECONDS} s are read: are these milliseconds?"
        raise _content_error(lasts, path, where)
    refuse_out_of_range(points.q, option)
    look_for_degrees(points.q, robot.tree, option)
    return _motion(robot, points)


def _content_error(message: str, path: Path, option: str) -> Exception:
    """The error for invalid content of a file; an ``InputError`` with an option's name, else a ``DescriptionError``."""
    if option:
        return InputError(option, f"{path.name}: {message}")
    return DescriptionError(message, str(path))


def _motion(robot: Robot, points: JointPoints) -> Trajectory:
    tree, (names, times, q, qd, qdd) = robot.tree, points
    checker, dynamics = robot._checker, robot._dynamics  # noqa: SLF001 - parts of the robot
    motion = Motion(make_space(tree, q, np.zeros(tree.n_dof, dtype=bool)), checker, None, 0.0, dynamics=dynamics)
    own, positions = described_limits(tree), PositionLimits(tree.lower, tree.upper)
    limits = own._replace(velocity=np.where(own.velocity > 0.0, own.velocity, np.inf))
    if len(q) == 1:
        return trajectory_at_rest(q[0], names, certified=False, motion=motion, limits=limits, positions=positions)
    ends = np.where(np.abs(qd[[0, -1]]) > _STILL, qd[[0, -1]], 0.0)
    qd[[0, -1]] = np.where(np.isfinite(qd[[0, -1]]), ends, np.nan)
    return Trajectory(False, names, interpolate_points(times, q, qd, qdd), motion, limits, Ends(*ends), positions)


def _read_message(robot: Robot, path: Path, rest: Array | None, option: str) -> JointPoints:
    """The points of a message, with all entries of q in order."""
    del option  # the errors have the path
    points, names = read_joint_points(path), entry_names(robot.tree)
    at = {name: k for k, name in enumerate(points.names)}
    missing = [name for name in names if name not in at]
    if len(missing) == len(names):
        raise DescriptionError(f"has none of the joints {listed(names, 12)}; it has {listed(points.names, 12)}", str(path))
    if missing and rest is None:
        raise DescriptionError(f"has no positions of {listed(missing, 12)}; give them with others=q", str(path))
    of_robot = {*names, *(joint.name for joint in robot.description.joints)}
    strange = [name for name in points.names if name not in of_robot]
    if strange:
        message = f"{path}: {listed(strange)}: the robot has no such joints; they are ignored"
        warnings.warn(message, DescriptionWarning, stacklevel=5)
    return _fill_other_joints(names, [name for name in names if name in at], points, rest)


def _fill_other_joints(names: Sequence[str], read: Sequence[str], points: JointPoints, rest: Array | None) -> JointPoints:
    """Extend points of some entries of q, in any order, to all entries; the others stay at ``rest``."""
    n, columns = len(points.times), [points.names.index(name) for name in read]
    whole = [
        np.tile(np.zeros(len(names)) if rest is None else rest, (n, 1)),
        np.zeros((n, len(names))),
        np.zeros((n, len(names))),
    ]
    to = [list(names).index(name) for name in read]
    for rows, given in zip(whole, points[2:], strict=True):
        rows[:, to] = given[:, columns]
        rows[np.isnan(given).any(axis=1)] = np.nan
    return JointPoints(tuple(names), points.times, *whole)


def _read_table(robot: Robot, path: Path, rest: Array | None, option: str) -> JointPoints:
    """The points of a table, by column names, or in the order time, q, velocities, accelerations."""
    names, n, read = entry_names(robot.tree), robot.n_dof, []
    rows = read_numbers(option, path, _motion_columns(robot, read, partly=rest is not None))
    k = len(read) or n
    if rows.ndim != 2 or rows.shape[1] not in {1 + k, 1 + 2 * k, 1 + 3 * k} or not len(rows):
        expected = f"rows of a time and {n} joint positions, velocities and accelerations are expected"
        raise InputError(option, f"{path.name} has shape {rows.shape}; {expected}, as `ulna plan --csv` writes them")
    refuse_infinite(option, path, rows)
    parts = [rows[:, 1 + i * k : 1 + (i + 1) * k] for i in range((rows.shape[1] - 1) // k)]
    parts += [np.full((len(rows), k), np.nan)] * (3 - len(parts))
    read = read or list(names)
    return _fill_other_joints(names, read, JointPoints(tuple(read), rows[:, 0], *parts), rest)


def _motion_columns(robot: Robot, read: list[str], *, partly: bool) -> Row:
    """The columns of a motion. Reading fills the list ``read`` with the entries of q that have columns.

    partly: whether joints may be missing.
    """
    joints, names = joint_columns(robot), entry_names(robot.tree)
    rates = [
        Quantity(f"{order} of {one.name}", rate_kind(one.kind, k), _rate_pattern(one.name, words))
        for k, (order, words) in enumerate(_ORDERS.items(), start=1)
        for one in joints.known
    ]

    def choose(found: Found) -> Sequence[str]:
        some = partly and any(name in found.at for name in names)
        positions = [name for name in names if name in found.at] if some else joints.chosen(found)
        read[:] = positions if some else names
        wanted = [TIMES.name, *positions]
        for order in _ORDERS:
            of = [f"{order} of {name}" for name in positions]
            if not all(name in found.at for name in (*positions, *of)):
                break  # accelerations without velocities are not used either
            for name, rate in zip(positions, of, strict=True):
                if found.at[name][1] not in {None, 1.0} and found.at[rate][1] is None:
                    raise ValueError(f"column {name!r} states a unit, but {rate!r} states none; [rad/s] or [deg/s] is expected")
            wanted += of
        return wanted

    return Row((*joints.known, *rates, TIMES), choose, joints.ignored)


def _rate_pattern(name: str, words: str) -> str:
    """A pattern for column names of a joint's velocity or acceleration, by the joint's name or number."""
    if name.startswith("#"):
        return rf"(?:{words}) ?(?:joint )?0*{name[1:]}"
    joint = re.escape(words_of(name))
    return rf"(?:{words}) {joint}|(?:.* )?{joint} (?:{words})"
