"""Reads rows of q from a file: .csv, or .npy as NumPy saves them. Used by ``record``."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.errors import FileError, InputError
from ulna.robot import Robot

_OPTION = "--trajectory"
_LONGEST = 100_000_000  # bytes


def read_trajectory(path: Path, robot: Robot) -> NDArray[np.float64]:
    """The rows of a file [rad or m], shape (n, n_dof).

    Raises:
        FileError: It cannot be read.
        InputError: It does not hold rows of q.
    """
    try:
        if path.stat().st_size > _LONGEST:
            raise InputError(_OPTION, f"{path.name} has more than {_LONGEST // 1_000_000} MB")
        rows = _array(path) if path.suffix.lower() == ".npy" else _table(path)
    except OSError as error:
        raise FileError(str(path), error.strerror or str(error)) from None
    if rows.ndim != 2 or rows.shape[1] != robot.n_dof or not len(rows):
        raise InputError(_OPTION, f"{path.name} has shape {rows.shape}; rows of {robot.n_dof} joint positions are expected")
    if not np.isfinite(rows).all():
        raise InputError(_OPTION, f"{path.name}: row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite")
    return rows


def _array(path: Path) -> NDArray[np.float64]:
    try:
        return np.asarray(np.load(path, allow_pickle=False), dtype=np.float64)
    except (ValueError, TypeError, EOFError):
        raise InputError(_OPTION, f"{path.name} is not a .npy file of numbers") from None


def _table(path: Path) -> NDArray[np.float64]:
    """Lines of numbers separated by commas or blanks; a first line of names is skipped."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    rows: list[list[float]] = []
    for k, line in enumerate(lines, start=1):
        words = line.replace(",", " ").split()
        try:
            row = [float(word) for word in words]
        except ValueError:
            if not rows and k == 1:
                continue
            raise InputError(_OPTION, f"{path.name}:{k}: {line.strip()[:60]!r} is not a row of numbers") from None
        if rows and row and len(row) != len(rows[0]):
            raise InputError(_OPTION, f"{path.name}:{k}: {len(row)} numbers, but {len(rows[0])} in the row before")
        rows += [row] if row else []
    return np.array(rows, dtype=np.float64).reshape(len(rows), -1) if rows else np.empty((0, 0))
