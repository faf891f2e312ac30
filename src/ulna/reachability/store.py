"""Lays a map out as a Zarr group, finds its finished chunks, and reads it.

    z, y, x          centers of the voxels [m]                          (z,), (y,), (x,)
    quaternion       the orientations, w first                          (orientation, wxyz)
    reached          -1 never computed, 1 reached, others: why not      (z, y, x, orientation)  int8
    branches         number of solutions; -1 if not counted             (z, y, x, orientation)  int8, closed forms of six joints
    manipulability   of the solution found; NaN if not reached          (z, y, x, orientation)  float32
    clearance        of the solution found [m]; NaN if not reached      (z, y, x, orientation)  float32, on request
    payload          maximum over known solutions [kg]; NaN if none     (z, y, x, orientation)  float32, on request
    q                the solution found [rad or m]                      (z, y, x, orientation, joint)  float32, on request

All variables are cut into the same chunks. ``reached`` is the last variable of a chunk to be written, by a rename. So if its file
exists, the chunk is complete.

Before zarr opens a file, the file is checked to be a regular one: a pipe would have no end. The arrays that zarr opens must have
this layout.
"""

from __future__ import annotations

import math
import os
import shutil
import stat
import uuid
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.description.file_bytes import json_value, regular_file_bytes
from ulna.errors import DescriptionError, FileError, needs_extra, reason_of
from ulna.reachability.grid import Grid
from ulna.reachability.specification import Specification
from ulna.reachability.verdicts import NOT_COMPUTED, NUMBERS

DIMENSIONS = ("z", "y", "x", "orientation")
META = "zarr.json"
_MAX_BYTES = 200_000_000  # of the group's metadata, which includes the robot and the world
_TEXTS = {
    "branches": (
        NOT_COMPUTED,
        "solutions within the limits, by the closed form; without collision, if there is a world; -1 never counted",
        "1",
    ),
    "manipulability": (np.nan, "sqrt(det(J J')) of the solution found; NaN where none was", "mixed"),
    "clearance": (np.nan, "signed distance of the solution found from the nearest object or link; NaN where none was", "m"),
    "payload": (np.nan, "largest mass at the link's origin that the motors hold, of any solution known; NaN where none is", "kg"),
    "q": (np.nan, "joint positions of the solution found; NaN where none was", "rad or m"),
}  # the value where nothing was computed, the long name and the units


def zarr_package() -> Any:
    """The package zarr."""
    with needs_extra("a reachability map", "reach", "zarr"):
        import zarr  # noqa: PLC0415 -- needs the extra
    return zarr


def create(path: Path, specification: Specification, joint_names: tuple[str, ...]) -> None:
    """Make an empty map; it appears complete or not at all."""
    zarr = zarr_package()
    part_path = path.with_name(f".{path.name}.{uuid.uuid4().hex}.part")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the specification of Zarr 3 does not have consolidated metadata yet
            group = zarr.create_group(part_path, attributes=_attributes(specification, joint_names))
            _add_coordinates(group, specification.grid)
            for name in variables(specification):
                _add_variable(group, name, specification.grid, len(joint_names))
            zarr.consolidate_metadata(part_path)
        part_path.rename(path)
    except OSError as error:
        raise FileError(str(path), f"the map cannot be written ({error.strerror or error})") from None
    finally:
        shutil.rmtree(part_path, ignore_errors=True)


def variables(specification: Specification) -> tuple[str, ...]:
    """The names of a map's variables, in the order of writing: the verdict last."""
    stored = {"branches": specification.branches, "manipulability": True}
    stored |= {"clearance": specification.clearance, "payload": specification.payload, "q": specification.solutions}
    return (*(name for name, is_stored in stored.items() if is_stored), "reached")


def read_specification(path: Path) -> Specification:
    """The specification of the map at a path."""
    return Specification.of_attributes(read_attributes(path), str(path))


def metadata_bytes(path: Path) -> bytes:
    """The group's own metadata; a map with other bytes is another map."""
    try:
        content = regular_file_bytes(path / META, _MAX_BYTES)
    except FileNotFoundError:
        raise FileError(str(path), "there is no reachability map") from None
    except OSError as error:
        raise FileError(str(path), reason_of(error)) from None
    if len(content) > _MAX_BYTES:
        raise FileError(str(path), f"its {META} has more than {_MAX_BYTES // 1_000_000} MB, the maximum")
    return content


def has_chunk(path: Path, place: tuple[int, ...]) -> bool:
    """Whether the chunk at a place exists."""
    return os.path.exists(verdict_file(path, place))  # noqa: PTH110 -- called for every chunk


def missing_chunks(path: Path, grid: Grid) -> list[int]:
    """The missing chunks, in their order."""
    return [chunk for chunk in range(grid.n_chunks) if not has_chunk(path, grid.place(chunk))]


def remove_partial_files(path: Path) -> None:
    """Remove half-written files of killed writers."""
    for part in path.rglob("*.partial"):
        part.unlink(missing_ok=True)


def verdict_file(path: Path, place: tuple[int, ...]) -> str:
    """The file of the verdicts of the chunk at a place."""
    return os.path.join(path, "reached", "c", *map(str, place))  # noqa: PTH118 -- called for every chunk


def layout(name: str, grid: Grid, n_joints: int) -> tuple[tuple[int, ...], tuple[int, ...], str]:
    """The shape, the chunks' shape and the type of a variable."""
    tail = (n_joints,) if name == "q" else ()
    kind = "int8" if name in ("reached", "branches") else "float32"
    return (*grid.shape, grid.orientations, *tail), (*grid.chunk_shape, *tail), kind


def read_attributes(path: Path) -> dict[str, Any]:
    """The attributes of the group."""
    content = metadata_bytes(path)
    try:
        found = json_value(content)
        attributes = found["attributes"]
    except (ValueError, KeyError, TypeError):
        raise DescriptionError("is not a reachability map", str(path)) from None
    if not isinstance(attributes, dict):
        raise DescriptionError("is not a reachability map", str(path))
    return attributes


def _attributes(specification: Specification, joint_names: tuple[str, ...]) -> dict[str, Any]:
    return {**specification.attributes(), "joint_names": list(joint_names), "coordinates": "quaternion"}


def _add_coordinates(group: Any, grid: Grid) -> None:
    for name, values in zip("zyx", grid.axes, strict=True):
        _add_coordinate(group, name, (name,), values, f"{name} of the voxel's center in the robot's base frame", "m")
    words = "orientation of the tip in the base frame, w first (super-Fibonacci, Alexa 2022)"
    _add_coordinate(group, "quaternion", ("orientation", "wxyz"), grid.wxyz, words, "1")


def _add_coordinate(group: Any, name: str, dimensions: tuple[str, ...], values: NDArray, long_name: str, units: str) -> None:
    attributes = {"units": units, "long_name": long_name}
    shape = values.shape
    array = group.create_array(
        name, shape=shape, chunks=shape, dtype="float64", dimension_names=dimensions, attributes=attributes
    )
    array[:] = values


def _add_variable(group: Any, name: str, grid: Grid, n_joints: int) -> None:
    shape, chunks, kind = layout(name, grid, n_joints)
    if name == "reached":
        fill, words = NOT_COMPUTED, ["never_computed", *(str(status).replace(" ", "_") for status in NUMBERS)]
        attributes: dict[str, Any] = {
            "long_name": "whether the pose is reached, or why not",
            "flag_values": [NOT_COMPUTED, *NUMBERS.values()],
            "flag_meanings": " ".join(words),
        }
    else:
        fill, long_name, units = _TEXTS[name]
        attributes = {"long_name": long_name, "units": units}
    group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype=kind,
        fill_value=fill,
        dimension_names=(*DIMENSIONS, *(("joint",) if name == "q" else ())),
        attributes=attributes,
    )


# ---- reading files that may be damaged or foreign -----------------------------------------------------------------------

_MAX_OF_ARRAY = 1_000_000  # bytes of an array's metadata, and of a chunk beyond twice its values


def open_arrays(path: Path, specification: Specification, n_joints: int, mode: str = "r") -> dict[str, Any]:
    """The arrays of a map's variables by their names."""
    zarr, names = zarr_package(), variables(specification)
    for name in names:
        _check_file(path / name / META, _MAX_OF_ARRAY)
    arrays = {}
    try:
        group = zarr.open_group(path, mode=mode, zarr_format=3, use_consolidated=False)
        for name in names:
            arrays[name] = group[name]
            found = arrays[name].shape, arrays[name].chunks, str(arrays[name].dtype)
            expected = layout(name, specification.grid, n_joints)
            if found != expected:
                raise ValueError(f"{name!r} has shape, chunks and type {found}; its attributes say {expected}")  # noqa: TRY301
    except Exception as error:  # noqa: BLE001 -- zarr and its codecs raise any exception
        raise DescriptionError(f"the map's arrays cannot be opened: {_words(error)}", str(path)) from None
    return arrays


def read_verdicts(path: Path, array: Any, grid: Grid, chunk: int) -> NDArray[np.int8]:
    """The verdicts of a chunk; ``NOT_COMPUTED`` where it was not computed."""
    check_chunks(path, grid, [grid.place(chunk)])
    try:
        return array[grid.region(chunk)]
    except Exception as error:  # noqa: BLE001 -- as above
        raise unreadable(Path(verdict_file(path, grid.place(chunk))), error) from None


def check_chunks(path: Path, grid: Grid, places: Iterable[tuple[int, ...]]) -> None:
    """Raise a ``FileError`` unless the verdicts of the chunks at some places are regular files, or absent."""
    for place in places:
        file = verdict_file(path, place)
        if os.path.lexists(file):
            _check_file(Path(file), 2 * math.prod(grid.chunk_shape) + _MAX_OF_ARRAY)


def unreadable(file: Path, error: Exception) -> FileError:
    """The error for a damaged chunk."""
    return FileError(
        str(file), f"cannot be read ({_words(error)}); remove this file, and resume=True (--resume) computes it again"
    )


def _check_file(file: Path, max_bytes: int) -> None:
    try:
        status = file.stat()
    except OSError as error:
        raise FileError(str(file), reason_of(error)) from None
    if not stat.S_ISREG(status.st_mode) or status.st_size > max_bytes:
        raise FileError(str(file), f"is not a regular file of at most {max_bytes} bytes, so it is not part of a map")


def _words(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
