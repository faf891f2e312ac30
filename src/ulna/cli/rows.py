"""Reads rows of q, motions, or poses from a .csv or .npy file; a .csv may name its columns."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.cli.options import warnings_printed
from ulna.description.columns import (
    ANGLE,
    LENGTH,
    NUMBER,
    RPY,
    WXYZ,
    XYZ,
    Found,
    Quantity,
    Row,
    words_of,
)
from ulna.description.controllers import Controller, pose_from
from ulna.description.number_rows import read_numbers, refuse_infinite
from ulna.description.pose import as_pose, pose
from ulna.errors import InputError
from ulna.robot import Robot
from ulna.robot.joint_columns import joint_columns
from ulna.robot.motion_file import motion_of_file

_OPTION, _PATH, _PLAN = "--trajectory", "--path", "--plan"
_RATE = 200  # rows per second of a motion


def read_trajectory(path: Path, robot: Robot) -> NDArray[np.float64]:
    """The rows of a file [rad or m], shape (n, n_dof)."""
    rows = read_numbers(_OPTION, path, joint_columns(robot))
    if rows.ndim != 2 or rows.shape[1] != robot.n_dof or not len(rows):
        raise InputError(_OPTION, f"{path.name} has shape {rows.shape}; rows of {robot.n_dof} joint positions are expected")
    refuse_infinite(_OPTION, path, rows)
    return rows


def read_motion(path: Path, robot: Robot) -> tuple[float, NDArray[np.float64]]:
    """The duration [s] of a motion file, and q at equal time steps [rad or m], shape (n, n_dof)."""
    with warnings_printed():
        motion = motion_of_file(robot, path, option=_PLAN)
    even = np.linspace(0.0, motion.duration, 1 + int(np.ceil(_RATE * motion.duration)))
    return motion.duration, motion.at(even).q


def read_poses(path: Path, controller: Controller | None = None) -> NDArray[np.float64]:
    """Read poses, shape (n, 4, 4), from a .npy file of that shape, or from rows of numbers.

    With a controller, a row states a pose in the controller's convention and units, and columns carry its labels. Otherwise a row
    is x, y, z, roll, pitch, yaw; or x, y, z, w, x, y, z with a quaternion; or the 12 or 16 numbers of a matrix, row by row.
    Columns with names may be in another order: x, y, z and roll, pitch, yaw, or qw, qx, qy, qz.
    """
    if controller is not None:
        return _poses_of_controller(path, controller)
    rows = read_numbers(_PATH, path, _OF_POSES)
    if rows.ndim == 3:
        rows = rows.reshape(len(rows), -1)
    if rows.ndim != 2 or rows.shape[1] not in _POSES or not len(rows):
        raise InputError(_PATH, f"{path.name} has shape {rows.shape}; rows of 6, 7, 12 or 16 numbers are expected")
    refuse_infinite(_PATH, path, rows)
    return as_pose(_POSES[rows.shape[1]](rows), _PATH)


def _poses_of_controller(path: Path, controller: Controller) -> NDArray[np.float64]:
    turns = NUMBER if controller.turns == "wxyz" else ANGLE
    per = np.array([controller.per_meter] * 3 + [controller.per_radian] * (len(controller.labels) - 3))
    known = [Quantity(label, LENGTH if k < 3 else turns, "", 1.0 / per[k]) for k, label in enumerate(controller.labels)]
    rows = read_numbers(_PATH, path, Row(known, lambda _: controller.labels, _OF_POSES.ignored))
    if rows.ndim != 2 or rows.shape[1] != len(known) or not len(rows):
        expected = f"rows of {', '.join(controller.labels)} [{controller.units}] are expected"
        raise InputError(_PATH, f"{path.name} has shape {rows.shape}; {expected}")
    refuse_infinite(_PATH, path, rows)
    return pose_from(rows * per, controller.name)


def _of_matrices(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    T = np.tile(np.eye(4), (len(rows), 1, 1))
    T.reshape(-1, 16)[:, : rows.shape[1]] = rows
    return T


_POSES = {
    6: lambda rows: pose(rows[:, :3], rows[:, 3:]),
    7: lambda rows: pose(rows[:, :3], wxyz=rows[:, 3:]),
    12: _of_matrices,
    16: _of_matrices,
}
_MATRIX = tuple(Quantity(f"m{i}{j}", NUMBER, rf"[a-z]+ ?{i} ?{j}") for i in range(5) for j in range(5))  # as in "r11"
_BESIDE = r"(?:.* )?(?:time|stamp|timestamp|t|secs?|nsecs?|nanosec|seq|id|index|frame)"


def _names_of_pose(found: Found) -> Sequence[str]:
    """The columns of a pose: a position and angles or a quaternion, or a matrix."""
    turns = [turn for turn in (RPY, WXYZ, _MATRIX) if any(one.name in found.at for one in turn)]
    if len(turns) > 1:
        raise ValueError("its names give the orientation in two ways; one of them is expected")
    if not turns:
        raise ValueError("its names give no orientation; roll, pitch, yaw or qw, qx, qy, qz are expected beside x, y, z")
    if turns != [_MATRIX]:
        return [one.name for one in (*XYZ, *turns[0])]
    first = 0 if any("0" in name for name in found.at) else 1
    names = [f"m{i + first}{j + first}" for i in range(4) for j in range(4)]
    if names[3] not in found.at:
        names[3:12:4] = [one.name for one in XYZ]
    return names if names[12] in found.at else names[:12]


_OF_POSES = Row(
    (*XYZ, *RPY, *WXYZ, *_MATRIX), _names_of_pose, lambda name: not name.strip() or bool(re.fullmatch(_BESIDE, words_of(name)))
)
