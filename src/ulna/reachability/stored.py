"""Opens the arrays of a map and reads chunks of its verdicts, which may be damaged or a stranger's.

Before the package zarr opens a file, it is seen to be a regular one: a pipe would have no end. What zarr then opens must have the
layout that ``store`` gives a map.
"""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import DescriptionError, FileError
from ulna.reachability.grid import Grid
from ulna.reachability.specification import Specification
from ulna.reachability.store import META, layout, variables, verdict_file, zarr_package

_MOST_BYTES = 1_000_000  # of an array's metadata, and of a chunk beyond twice its values


def open_arrays(path: Path, specification: Specification, n_joints: int, mode: str = "r") -> dict[str, Any]:
    """The arrays of a map's variables by their names."""
    zarr, names = zarr_package(), variables(specification)
    for name in names:
        _check_file(path / name / META, _MOST_BYTES)
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
    """The verdicts of a chunk; ``NEVER`` where it was not computed."""
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
            _check_file(Path(file), 2 * math.prod(grid.chunk_shape) + _MOST_BYTES)


def unreadable(file: Path, error: Exception) -> FileError:
    """The error for a chunk that is damaged."""
    return FileError(
        str(file), f"cannot be read ({_words(error)}); remove this file, and resume=True (--resume) computes it again"
    )


def _check_file(file: Path, most: int) -> None:
    try:
        status = file.stat()
    except OSError as error:
        raise FileError(str(file), error.strerror or str(error)) from None
    if not stat.S_ISREG(status.st_mode) or status.st_size > most:
        raise FileError(str(file), f"is not a regular file of at most {most} bytes, so it is not part of a map")


def _words(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
