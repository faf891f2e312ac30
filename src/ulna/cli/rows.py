"""Reads rows of q, motions, or poses from a file: .csv, or .npy as NumPy saves them. Names in its first line say what is what."""

import re
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.columns import (
    ANGLE,
    LENGTH,
    NUMBER,
    RPY,
    TIMES,
    WXYZ,
    XYZ,
    Found,
    Quantity,
    Row,
    columns_of,
    fields_of,
    head_of,
    is_row,
    number_of,
    text_of,
    words_of,
)
from ulna.description.controllers import Controller, pose_from
from ulna.description.file_bytes import file_bytes
from ulna.description.file_costs import check_numbers
from ulna.description.pose import as_pose, pose
from ulna.errors import FileError, InputError, count_of, reason_of
from ulna.robot import Robot
from ulna.robot.joint_columns import joint_columns

_OPTION, _PATH, _PLAN = "--trajectory", "--path", "--plan"
_RATE = 200  # rows a second of a motion
_LONGEST = 100_000_000  # bytes
_MAX_NUMBERS = 10_000_000  # of a text, which take 40 bytes each until they are an array
_MAX_SECONDS = 7200  # of a motion: above a million rows


def read_trajectory(path: Path, robot: Robot) -> NDArray[np.float64]:
    """The rows of a file [rad or m], shape (n, n_dof)."""
    rows = _read(_OPTION, path, joint_columns(robot))
    if rows.ndim != 2 or rows.shape[1] != robot.n_dof or not len(rows):
        raise InputError(_OPTION, f"{path.name} has shape {rows.shape}; rows of {robot.n_dof} joint positions are expected")
    _refuse_infinite(_OPTION, path, rows)
    return rows


def read_motion(path: Path, robot: Robot) -> tuple[float, NDArray[np.float64]]:
    """The duration [s] of a motion as ``ulna plan --csv`` writes it, and rows of q at even times [rad or m], shape (n, n_dof)."""
    joints = joint_columns(robot)
    timed = Row((*joints.known, TIMES), lambda found: [TIMES.name, *joints.chosen(found)], joints.ignored)
    rows, n = _read(_PLAN, path, timed), robot.n_dof
    if rows.ndim != 2 or rows.shape[1] not in {1 + n, 1 + 3 * n} or not len(rows):
        expected = f"rows of a time and {n} joint positions, velocities and accelerations are expected"
        raise InputError(_PLAN, f"{path.name} has shape {rows.shape}; {expected}, as `ulna plan --csv` writes them")
    _refuse_infinite(_PLAN, path, rows)
    times = rows[:, 0] - rows[0, 0]
    if (np.diff(times) <= 0.0).any():
        k = int(np.flatnonzero(np.diff(times) <= 0.0)[0])
        raise InputError(_PLAN, f"{path.name}: row {k + 1} is not later than the row before")
    if times[-1] > _MAX_SECONDS:
        raise InputError(_PLAN, f"{path.name} lasts {times[-1]:g} s; up to {_MAX_SECONDS} s are read: are these milliseconds?")
    even = np.linspace(0.0, times[-1], 1 + int(np.ceil(_RATE * times[-1])))
    return float(times[-1]), np.column_stack([np.interp(even, times, column) for column in rows[:, 1 : 1 + n].T])


def read_poses(path: Path, controller: Controller | None = None) -> NDArray[np.float64]:
    """The poses of a file, shape (n, 4, 4): of a .npy file of that shape, or of rows of numbers.

    With a controller a row is as that states a pose, in its units; names of columns are then its labels.

    A row is x, y, z, roll, pitch, yaw; or x, y, z, w, x, y, z with the orientation as a quaternion; or the 12 or 16 numbers of a
    matrix, row by row. Columns with names may be in another order: x, y, z and roll, pitch, yaw, or qw, qx, qy, qz.
    """
    if controller is not None:
        return _poses_of_controller(path, controller)
    rows = _read(_PATH, path, _OF_POSES)
    if rows.ndim == 3:
        rows = rows.reshape(len(rows), -1)
    if rows.ndim != 2 or rows.shape[1] not in _POSES or not len(rows):
        raise InputError(_PATH, f"{path.name} has shape {rows.shape}; rows of 6, 7, 12 or 16 numbers are expected")
    _refuse_infinite(_PATH, path, rows)
    poses = np.array([_POSES[rows.shape[1]](row) for row in rows])
    return as_pose(poses, _PATH)


def _poses_of_controller(path: Path, controller: Controller) -> NDArray[np.float64]:
    turns = NUMBER if controller.turns == "wxyz" else ANGLE
    per = np.array([controller.per_metre] * 3 + [controller.per_radian] * (len(controller.labels) - 3))
    known = [Quantity(label, LENGTH if k < 3 else turns, "", 1.0 / per[k]) for k, label in enumerate(controller.labels)]
    rows = _read(_PATH, path, Row(known, lambda _: controller.labels, _OF_POSES.ignored))
    if rows.ndim != 2 or rows.shape[1] != len(known) or not len(rows):
        expected = f"rows of {', '.join(controller.labels)} [{controller.units}] are expected"
        raise InputError(_PATH, f"{path.name} has shape {rows.shape}; {expected}")
    _refuse_infinite(_PATH, path, rows)
    return pose_from(rows * per, controller.name)


def _of_matrix(row: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.vstack([row[:12].reshape(3, 4), row[12:] if len(row) > 12 else [0.0, 0.0, 0.0, 1.0]])


_POSES = {6: lambda row: pose(row[:3], row[3:]), 7: lambda row: pose(row[:3], wxyz=row[3:]), 12: _of_matrix, 16: _of_matrix}
_MATRIX = tuple(Quantity(f"m{i}{j}", NUMBER, rf"[a-z]+ ?{i} ?{j}") for i in range(5) for j in range(5))  # as in "r11"
_BESIDE = r"(?:.* )?(?:time|stamp|timestamp|t|secs?|nsecs?|nanosec|seq|id|index|frame)"


def _names_of_pose(found: Found) -> Sequence[str]:
    """The columns of a pose: a place and an angle or a quaternion, or a matrix."""
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


def _read(option: str, path: Path, row: Row) -> NDArray[np.float64]:
    try:
        content = file_bytes(path, _LONGEST)
    except OSError as error:
        raise FileError(str(path), reason_of(error)) from None
    if len(content) > _LONGEST:
        raise InputError(option, f"{path.name} has more than {_LONGEST // 1_000_000} MB")
    ending = path.suffix.lower()
    try:
        check_numbers(".npy" if ending == ".npy" else ".csv", content, _MAX_NUMBERS)
        return (_array if ending == ".npy" else _table)(option, path, content, row)
    except MemoryError:
        raise FileError(str(path), "cannot be read: out of memory") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(option, f"{path.name}: {error}") from None


def _refuse_infinite(option: str, path: Path, rows: NDArray[np.float64]) -> None:
    if not np.isfinite(rows).all():
        raise InputError(option, f"{path.name}: row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite")


def _array(option: str, path: Path, content: bytes, row: Row) -> NDArray[np.float64]:
    try:
        array = np.load(BytesIO(content), allow_pickle=False)
        if array.dtype.names is None:
            return _in_si(np.asarray(array, dtype=np.float64), row)
        fields = {name: np.asarray(array[name], dtype=np.float64).reshape(-1) for name in array.dtype.names}
    except (ValueError, TypeError, EOFError):
        raise InputError(option, f"{path.name} is not a .npy file of numbers") from None
    columns, scales = _columns(option, path, array.dtype.names, row)
    return np.column_stack([fields[array.dtype.names[column]] for column in columns]) * scales


def _columns(option: str, path: Path, names: Sequence[str], row: Row) -> tuple[list[int], NDArray[np.float64]]:
    try:
        columns, units = columns_of(names, row)
    except ValueError as error:
        raise InputError(option, f"{path.name}: {error}") from None
    return columns, np.array(units)


def _table(option: str, path: Path, content: bytes, row: Row) -> NDArray[np.float64]:
    """Lines of numbers separated by commas, semicolons or blanks; the first line may have names."""
    lines = text_of(content).splitlines()
    try:
        head = head_of(lines, row.known)
    except ValueError as error:
        raise InputError(option, f"{path.name}: {error}") from None
    if head is None:
        raise InputError(option, f"{path.name} has no row of numbers")
    columns, scales = None, np.ones(1)
    if head.names is not None:
        columns, scales = _columns(option, path, head.names, row)
    rows: list[list[float]] = []
    for k, line in enumerate(lines[head.first :], start=head.first + 1):
        if not is_row(line):
            continue
        try:
            fields = fields_of(line, head.separator)
            if len(fields) == head.n_columns or columns is None:
                rows.append([number_of(fields[column], head) for column in columns or range(len(fields))])
        except ValueError:
            raise InputError(option, f"{path.name}:{k}: {line.strip()[:60]!r} is not a row of numbers") from None
        if len(fields) != head.n_columns:
            raise InputError(
                option, f"{path.name}:{k}: {count_of(len(fields), 'number')}, but {head.n_columns} in the row before"
            )
    table = np.array(rows, dtype=np.float64)
    return _in_si(table, row) if columns is None else table * scales


def _in_si(table: NDArray[np.float64], row: Row) -> NDArray[np.float64]:
    """A table without names, each column in its usual unit, in m, rad or s."""
    units = np.array([one.unit for one in row.known])
    return table if (units == 1.0).all() or table.shape[-1:] != units.shape else table * units
