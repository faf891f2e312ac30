"""Caches the convex pieces of meshes on disk, in the user's own cache folder."""

import contextlib
import io
import zipfile
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.private_folder import PrivateFolder, cache_base, private_folder

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
    with contextlib.suppress(OSError, RuntimeError, ValueError), _folder() as folder:
        return from_bytes(folder.read(f"{name}.npz"))
    return None


def write(name: str, pieces: Pieces) -> None:
    """Cache pieces under a name, if the folder can be written; remove files that were not used for three months."""
    with contextlib.suppress(OSError, RuntimeError), _folder() as folder:
        folder.write(f"{name}.npz", to_bytes(pieces))
        folder.remove_unused(_UNUSED_DAYS)


def _folder() -> PrivateFolder:
    """The cache folder.

    Raises:
        OSError: It cannot be written, or other users could write there.
        RuntimeError: The user has no home folder.
    """
    with private_folder(cache_base()) as base:
        return base.folder("pieces")
