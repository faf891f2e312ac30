"""Writes a table of numbers as a .csv file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.errors import FileError


def write_table(path: str | Path, names: Sequence[str], rows: NDArray[np.float64]) -> None:
    """Write a line of names, then a line for each row, shape (n, k), every number with all of its digits."""
    lines = [",".join(names), *(",".join(map(repr, row)) for row in rows.tolist())]
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise FileError(str(path), error.strerror or str(error)) from None
