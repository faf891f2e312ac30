"""Reads points from a file: .npy, .xyz, .csv, .ply or .pcd."""

import re
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.description.columns import XYZ, find_columns, head_of, is_row, required, text_of
from ulna.description.file_costs import check_numbers
from ulna.description.pose import pose
from ulna.errors import FileError, UlnaError, count_of, needs_extra

_TYPES = {"F": "f", "I": "i", "U": "u"}  # of a .pcd, and NumPy's letter for each


class Meaning(NamedTuple):
    """The unit and the frame of a file's points.

    Attributes:
        scale: Their unit [m].
        from_sensor: Whether they are in the frame of the sensor, whose pose a .pcd may contain; None if unknown.
    """

    scale: float = 1.0
    from_sensor: bool | None = None


def points_of(name: str, content: bytes, scale: float, *, from_sensor: bool | None = None) -> NDArray[np.float64]:
    """The points of a file [m], shape (n, 3), n >= 1.

    Args:
        name: The name of the file; its ending selects the format.
        content: Its bytes.
        scale: The unit of the file [m].
        from_sensor: As in ``PointCloud.from_file``.

    Raises:
        FileError: The format is not known, or the points cannot be read.
        MissingExtraError: A .ply needs an extra that is not installed.
    """
    reader = READERS.get(Path(name).suffix.lower())
    if reader is None:
        raise FileError(name, f"ends in none of {', '.join(READERS)}")
    try:
        check_numbers(Path(name).suffix.lower(), content)
        points = reader(content, Meaning(scale, from_sensor)).astype(np.float64)
    except UlnaError:
        raise
    except MemoryError:
        raise FileError(name, "cannot be read: out of memory") from None
    except Exception as error:  # noqa: BLE001 - trimesh and its dependencies raise any exception
        raise FileError(name, f"cannot be read: {' '.join(str(error).split())[:200] or type(error).__name__}") from None
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise FileError(name, f"has an array of shape {points.shape}; points of shape (n, 3) are expected")
    return points[:, :3]


def _npy(content: bytes, meaning: Meaning) -> NDArray:
    """Read an array of points or of records.

    Points have the shape (n, 3) or (H, W, 3); records have the shape (n,) or (H, W) and the fields x, y, z.
    """
    array = np.load(BytesIO(content), allow_pickle=False)
    if array.dtype.names is not None:
        columns, scale = _named_columns(array.dtype.names, meaning.scale)
        return np.column_stack([_flat_numbers(array[array.dtype.names[column]]) for column in columns]) * scale
    if array.dtype.kind not in "fiu":
        raise ValueError(f"its entries are {array.dtype}; numbers are expected")
    return (array.reshape(-1, array.shape[-1]) if array.ndim > 2 else array) * meaning.scale


def _text(content: bytes, meaning: Meaning) -> NDArray[np.float64]:
    """Read lines of numbers separated by blanks, commas or semicolons: the columns named x, y, z, else the first three."""
    lines = text_of(content).splitlines()
    head = head_of(lines, XYZ)
    if head is None:
        return np.empty((0, 3))
    columns, scale = ([0, 1, 2], meaning.scale) if head.names is None else _named_columns(head.names, meaning.scale)
    rows = [line for line in lines[head.first :] if is_row(line)]
    if head.decimal_comma:
        if any("." in row for row in rows):
            raise ValueError("it has numbers with a point and numbers with a comma")
        rows = [row.replace(",", ".") for row in rows]
    return np.loadtxt(rows, delimiter=head.separator, usecols=columns, ndmin=2, quotechar='"') * scale


def _named_columns(names: Sequence[str], scale: float) -> tuple[list[int], float]:
    """The indices of the columns x, y, z, and their unit [m].

    A unit in the columns' names must not contradict ``scale``.
    """
    columns, factors = required(find_columns(names, XYZ), "xyz", names)
    if len(set(factors)) > 1:
        raise ValueError(f"the columns {', '.join(repr(names[column]) for column in columns)} have different units")
    named_unit = factors[0]
    if named_unit is not None and scale not in {1.0, named_unit}:
        raise ValueError(
            f"column {names[columns[0]]!r} is in units of {named_unit:g} m, but the scale is {scale:g}; leave that out"
        )
    return columns, scale if named_unit is None else named_unit


def _flat_numbers(field: NDArray) -> NDArray:
    """The numbers of a field of records, shape (n,)."""
    if field.dtype.kind not in "fiu":
        raise ValueError(f"a field has entries of {field.dtype}; numbers are expected")
    return field.reshape(-1)


def _ply(content: bytes, meaning: Meaning) -> NDArray[np.float64]:
    with needs_extra("reading a .ply", "hulls", "trimesh"):
        from ulna.description.meshes import ply  # noqa: PLC0415 - an extra
    return ply.vertices(content) * meaning.scale


def _pcd(content: bytes, meaning: Meaning) -> NDArray[np.float64]:
    """Read the fields x, y, z of a .pcd, as text or binary.

    Source: Point Cloud Library, The PCD file format, version 0.7.
    """
    data_line = re.search(rb"^DATA +(\w+)\r?\n", content, re.MULTILINE)
    if data_line is None:
        raise ValueError("it has no line DATA")
    lines = content[: data_line.start()].decode(errors="replace").splitlines()
    header = {words[0]: words[1:] for words in map(str.split, lines) if words}
    fields, n = header["FIELDS"], int(header["POINTS"][0])
    counts = [int(count) for count in header.get("COUNT", ["1"] * len(fields))]
    for axis in "xyz":
        if fields.count(axis) != 1 or counts[fields.index(axis)] != 1:
            raise ValueError(f"its FIELDS are {' '.join(fields)[:100]}; one {axis} is expected, of one number")
    body, form = content[data_line.end() :], data_line[1].decode()
    if form == "ascii":
        first = np.cumsum([0, *counts])
        columns = [int(first[fields.index(axis)]) for axis in "xyz"]
        points = np.loadtxt(body.decode(errors="replace").splitlines(), usecols=columns, ndmin=2)
    elif form == "binary":
        kinds = [f"<{_TYPES[kind]}{size}" for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)]
        names = [field if field in "xyz" else f"{field} {k}" for k, field in enumerate(fields)]
        row = np.dtype([(name, kind, (count,)) for name, kind, count in zip(names, kinds, counts, strict=True)])
        rows = np.frombuffer(body[: n * row.itemsize], row)
        points = np.column_stack([rows[axis] for axis in "xyz"])
    else:
        raise ValueError(f"its points are {form}; ascii and binary are read")
    if len(points) != n:
        raise ValueError(f"{len(points)} of its {count_of(n, 'point')} can be read")
    return _apply_viewpoint(points, header.get("VIEWPOINT", []), from_sensor=meaning.from_sensor) * meaning.scale


def _apply_viewpoint(points: NDArray, words: Sequence[str], *, from_sensor: bool | None) -> NDArray:
    """Move the points of a .pcd by its VIEWPOINT if they are in the frame of the sensor.

    VIEWPOINT is x, y, z, then the quaternion w, x, y, z. The sensor writes exact zeros for a missing measurement. Moved, they
    would be points at the sensor, so they become NaN.
    """
    values = [float(word) for word in words]
    if from_sensor is False or not values or values == [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]:
        return points
    if from_sensor is None:
        raise ValueError(
            f"its VIEWPOINT is {' '.join(words)[:100]}, a pose of the sensor: from_sensor=True moves the points by it, "
            "False takes them as they are (VIEWPOINT 0 0 0 1 0 0 0 in the file)"
        )
    if len(values) != 7 or not any(values[3:]):
        raise ValueError(f"its VIEWPOINT is {' '.join(words)[:100]}; a place and a quaternion are expected")
    T = pose(values[:3], wxyz=values[3:])
    moved = points @ T[:3, :3].T + T[:3, 3]
    moved[~points.any(axis=1)] = np.nan
    return moved


READERS: dict[str, Callable[[bytes, Meaning], NDArray]] = {
    ".npy": _npy,
    ".xyz": _text,
    ".csv": _text,
    ".txt": _text,
    ".ply": _ply,
    ".pcd": _pcd,
}
