"""Caches the convex pieces of meshes, and the balls that cover them, on disk, in the user's cache folder."""

import contextlib
import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ulna.engine.private_folder import PrivateFolder, cache_base, private_folder

Parsed = TypeVar("Parsed")
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
    """Parse the bytes of ``to_bytes``."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            points, counts, excess = arrays["points"].astype(np.float64), arrays["counts"], float(arrays["excess"])
    except (OSError, EOFError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(str(error)) from None
    if points.ndim != 2 or points.shape[1] != 3 or not len(counts) or counts.min() < 1 or counts.sum() != len(points):
        raise ValueError("not the points of pieces")
    return Pieces(tuple(np.split(points, np.cumsum(counts)[:-1])), excess)


def balls_to_bytes(balls: NDArray[np.float64]) -> bytes:
    """Centers and radii, shape (n, 4), as the bytes of a NumPy file."""
    file = io.BytesIO()
    np.save(file, balls)
    return file.getvalue()


def balls_from_bytes(data: bytes) -> NDArray[np.float64]:
    """Parse the bytes of ``balls_to_bytes``."""
    try:
        balls = np.load(io.BytesIO(data), allow_pickle=False).astype(np.float64)
    except (OSError, EOFError, TypeError, AttributeError) as error:
        raise ValueError(str(error)) from None
    if balls.ndim != 2 or balls.shape[1] != 4 or not len(balls) or not np.isfinite(balls).all() or balls[:, 3].min() < 0:
        raise ValueError("not centers and radii of balls")
    return balls


def file_name(made_by: list[Any], data: bytes, ending: str) -> str:
    """The file name of a result computed from a mesh file's content and from ``made_by``, everything else it depends on."""
    return hashlib.sha256(json.dumps(made_by).encode() + b"\0" + data).hexdigest() + ending


def read(file: str, parse: Callable[[bytes], Parsed]) -> Parsed | None:
    """The parsed content of a cached file; None if the file is missing, or ``parse`` raises ValueError."""
    with contextlib.suppress(OSError, RuntimeError, ValueError), _folder() as folder:
        return parse(folder.read(file))
    return None


def write(file: str, data: bytes) -> None:
    """Cache a file, if the folder can be written; remove files that were not used for three months."""
    with contextlib.suppress(OSError, RuntimeError), _folder() as folder:
        folder.write(file, data)
        folder.remove_unused(_UNUSED_DAYS)


def _folder() -> PrivateFolder:
    """The cache folder; raises OSError if others could write there, RuntimeError for a user without a home folder."""
    with private_folder(cache_base()) as base:
        return base.folder("pieces")
