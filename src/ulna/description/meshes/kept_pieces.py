"""Caches the convex pieces of meshes on disk, in the user's own cache folder. Used by ``decompose`` and its child process."""

import contextlib
import io
import os
import time
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.private_folder import SharedFolderError, cache_base, make_private
from ulna.engine.whole_file import write_whole

_UNUSED_DAYS = 90


class Pieces(NamedTuple):
    """Convex pieces of a mesh.

    Attributes:
        points: The corners of each, shape (n, 3).
        excess: The largest distance [m] of the pieces from the mesh, by sampling (``pieces.sampled_excess``).
    """

    points: tuple[NDArray[np.float64], ...]
    excess: float


def to_bytes(pieces: Pieces) -> bytes:
    """The pieces as the bytes of a NumPy file."""
    file = io.BytesIO()
    np.savez(file, points=np.concatenate(pieces.points), counts=[len(one) for one in pieces.points], excess=pieces.excess)
    return file.getvalue()


def from_bytes(data: bytes) -> Pieces:
    """The pieces of such a file.

    Raises:
        ValueError: The file does not hold pieces.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            points, counts, excess = arrays["points"].astype(np.float64), arrays["counts"], float(arrays["excess"])
    except (OSError, EOFError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(str(error)) from None
    if points.ndim != 2 or points.shape[1] != 3 or not len(counts) or counts.min() < 1 or counts.sum() != len(points):
        raise ValueError("not the points of pieces")
    return Pieces(tuple(np.split(points, np.cumsum(counts)[:-1])), excess)


def read(name: str) -> Pieces | None:
    """The cached pieces of a name; None if there are none."""
    folder = _folder()
    if folder is None:
        return None
    path = folder / f"{name}.npz"
    try:
        pieces = from_bytes(path.read_bytes())
        os.utime(path)
    except (OSError, ValueError):
        return None
    return pieces


def write(name: str, pieces: Pieces) -> None:
    """Cache pieces under a name, if the folder can be written; remove files that were not used for three months."""
    folder = _folder()
    if folder is None:
        return
    with contextlib.suppress(OSError):
        write_whole(folder / f"{name}.npz", to_bytes(pieces))
        for path in folder.iterdir():
            if path.stat().st_mtime < time.time() - _UNUSED_DAYS * 86400:
                path.unlink()


def _folder() -> Path | None:
    """The cache folder; None if it cannot be written, or other users could write there."""
    try:
        return make_private(cache_base(), "pieces")
    except (SharedFolderError, OSError, RuntimeError):  # RuntimeError: a user without a home folder
        return None
