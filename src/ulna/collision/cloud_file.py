"""Reads points from a file: .npy, .xyz, .csv, .ply or .pcd."""

import re
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.file_costs import check_numbers
from ulna.errors import FileError, UlnaError, needs_extra

_TYPES = {"F": "f", "I": "i", "U": "u"}  # of a .pcd, as NumPy has them


def points_of(name: str, content: bytes, scale: float) -> NDArray[np.float64]:
    """The points of a file [m], shape (n, 3), n >= 1.

    Args:
        name: The name of the file; its ending gives the format.
        content: Its bytes.
        scale: The unit of the file [m].

    Raises:
        FileError: The format is not known, or the points cannot be read.
        MissingExtraError: What reads a .ply is not installed.
    """
    reader = READERS.get(Path(name).suffix.lower())
    if reader is None:
        raise FileError(name, f"ends in none of {', '.join(READERS)}")
    try:
        check_numbers(Path(name).suffix.lower(), content)
        points = reader(content).astype(np.float64) * scale
    except UlnaError:
        raise
    except MemoryError:
        raise FileError(name, "cannot be read: out of memory") from None
    except Exception as error:  # noqa: BLE001 - trimesh and its dependencies raise any exception
        raise FileError(name, f"cannot be read: {' '.join(str(error).split())[:200] or type(error).__name__}") from None
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise FileError(name, f"has an array of shape {points.shape}; points of shape (n, 3) are expected")
    return points[:, :3]


def _npy(content: bytes) -> NDArray:
    """An array of points, shape (n, 3) or (H, W, 3)."""
    array = np.load(BytesIO(content), allow_pickle=False)
    return array.reshape(-1, array.shape[-1]) if array.ndim > 2 else array


def _text(content: bytes) -> NDArray[np.float64]:
    """Lines of numbers between spaces, commas or semicolons, the first three a point; the first line may be names."""
    lines = re.sub(r"[,;\t]", " ", content.decode(errors="replace")).splitlines()
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith(("#", "//"))]
    if rows and not re.search(r"\d", rows[0]):
        rows = rows[1:]
    return np.loadtxt(rows, usecols=(0, 1, 2), ndmin=2) if rows else np.empty((0, 3))


def _ply(content: bytes) -> NDArray[np.float64]:
    with needs_extra("reading a .ply", "hulls", "trimesh"):
        from ulna.description.meshes import ply  # noqa: PLC0415 - an extra
    return ply.vertices(content)


def _pcd(content: bytes) -> NDArray[np.float64]:
    """The fields x, y, z of a .pcd, as text or binary. Source: Point Cloud Library, The PCD file format, version 0.7."""
    found = re.search(rb"^DATA +(\w+)\r?\n", content, re.MULTILINE)
    if found is None:
        raise ValueError("it has no line DATA")
    lines = content[: found.start()].decode(errors="replace").splitlines()
    head = {words[0]: words[1:] for words in map(str.split, lines) if words}
    fields, n = head["FIELDS"], int(head["POINTS"][0])
    counts = [int(count) for count in head.get("COUNT", ["1"] * len(fields))]
    body, form = content[found.end() :], found[1].decode()
    if form == "ascii":
        first = np.cumsum([0, *counts])
        columns = [int(first[fields.index(axis)]) for axis in "xyz"]
        points = np.loadtxt(body.decode(errors="replace").splitlines(), usecols=columns, ndmin=2)
    elif form == "binary":
        kinds = [f"<{_TYPES[kind]}{size}" for kind, size in zip(head["TYPE"], head["SIZE"], strict=True)]
        names = [field if field in "xyz" else f"{field} {k}" for k, field in enumerate(fields)]
        row = np.dtype([(name, kind, (count,)) for name, kind, count in zip(names, kinds, counts, strict=True)])
        rows = np.frombuffer(body[: n * row.itemsize], row)
        points = np.column_stack([rows[axis] for axis in "xyz"])
    else:
        raise ValueError(f"its points are {form}; ascii and binary are read")
    if len(points) != n:
        raise ValueError(f"{len(points)} of its {n} points can be read")
    return points


READERS: dict[str, Callable[[bytes], NDArray]] = {".npy": _npy, ".xyz": _text, ".csv": _text, ".ply": _ply, ".pcd": _pcd}
