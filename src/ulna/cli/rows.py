"""Reads rows of q, motions, or poses from a file: .csv, or .npy as NumPy saves them."""

from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.file_bytes import file_bytes
from ulna.description.file_costs import check_numbers
from ulna.description.pose import as_pose, pose
from ulna.errors import FileError, InputError
from ulna.robot import Robot

_OPTION, _PATH, _PLAN = "--trajectory", "--path", "--plan"
_RATE = 200  # rows a second of a motion
_LONGEST = 100_000_000  # bytes
_MAX_NUMBERS = 10_000_000  # of a text, which take 40 bytes each until they are an array
_MAX_SECONDS = 7200  # of a motion: above a million rows


def read_trajectory(path: Path, robot: Robot) -> NDArray[np.float64]:
    """The rows of a file [rad or m], shape (n, n_dof)."""
    rows = _read(_OPTION, path)
    if rows.ndim != 2 or rows.shape[1] != robot.n_dof or not len(rows):
        raise InputError(_OPTION, f"{path.name} has shape {rows.shape}; rows of {robot.n_dof} joint positions are expected")
    _refuse_infinite(_OPTION, path, rows)
    return rows


def read_motion(path: Path, robot: Robot) -> tuple[float, NDArray[np.float64]]:
    """The duration [s] of a motion as ``ulna plan --csv`` writes it, and rows of q at even times [rad or m], shape (n, n_dof)."""
    rows, n = _read(_PLAN, path), robot.n_dof
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


def read_poses(path: Path) -> NDArray[np.float64]:
    """The poses of a file, shape (n, 4, 4): of a .npy file of that shape, or of rows of numbers.

    A row is x, y, z, roll, pitch, yaw; or x, y, z, w, x, y, z with the orientation as a quaternion; or the 12 or 16 numbers of a
    matrix, row by row.
    """
    rows = _read(_PATH, path)
    if rows.ndim == 3:
        rows = rows.reshape(len(rows), -1)
    if rows.ndim != 2 or rows.shape[1] not in _POSES or not len(rows):
        raise InputError(_PATH, f"{path.name} has shape {rows.shape}; rows of 6, 7, 12 or 16 numbers are expected")
    _refuse_infinite(_PATH, path, rows)
    poses = np.array([_POSES[rows.shape[1]](row) for row in rows])
    return as_pose(poses, _PATH)


def _of_matrix(row: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.vstack([row[:12].reshape(3, 4), row[12:] if len(row) > 12 else [0.0, 0.0, 0.0, 1.0]])


_POSES = {6: lambda row: pose(row[:3], row[3:]), 7: lambda row: pose(row[:3], wxyz=row[3:]), 12: _of_matrix, 16: _of_matrix}


def _read(option: str, path: Path) -> NDArray[np.float64]:
    try:
        content = file_bytes(path, _LONGEST)
    except OSError as error:
        raise FileError(str(path), error.strerror or str(error)) from None
    if len(content) > _LONGEST:
        raise InputError(option, f"{path.name} has more than {_LONGEST // 1_000_000} MB")
    ending = path.suffix.lower()
    try:
        check_numbers(".npy" if ending == ".npy" else ".csv", content, _MAX_NUMBERS)
        return _array(option, path, content) if ending == ".npy" else _table(option, path, content)
    except MemoryError:
        raise FileError(str(path), "cannot be read: out of memory") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(option, f"{path.name}: {error}") from None


def _refuse_infinite(option: str, path: Path, rows: NDArray[np.float64]) -> None:
    if not np.isfinite(rows).all():
        raise InputError(option, f"{path.name}: row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite")


def _array(option: str, path: Path, content: bytes) -> NDArray[np.float64]:
    try:
        return np.asarray(np.load(BytesIO(content), allow_pickle=False), dtype=np.float64)
    except (ValueError, TypeError, EOFError):
        raise InputError(option, f"{path.name} is not a .npy file of numbers") from None


def _table(option: str, path: Path, content: bytes) -> NDArray[np.float64]:
    """Lines of numbers separated by commas or blanks; a first line without a number has names, and is skipped."""
    lines = content.decode(errors="replace").splitlines()
    rows: list[list[float]] = []
    for k, line in enumerate(lines, start=1):
        words = line.replace(",", " ").split()
        try:
            row = [float(word) for word in words]
        except ValueError:
            if k == 1 and not any(map(_is_number, words)):
                continue
            raise InputError(option, f"{path.name}:{k}: {line.strip()[:60]!r} is not a row of numbers") from None
        if rows and row and len(row) != len(rows[0]):
            raise InputError(option, f"{path.name}:{k}: {len(row)} numbers, but {len(rows[0])} in the row before")
        rows += [row] if row else []
    if not rows:
        raise InputError(option, f"{path.name} has no row of numbers")
    return np.array(rows, dtype=np.float64)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
