"""Reads rows of numbers from a text or a .npy file; the first line may name the columns."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ulna.description.columns import Row, columns_of, fields_of, head_of, is_row, number_of, text_of
from ulna.description.file_bytes import file_bytes
from ulna.description.file_costs import check_numbers
from ulna.errors import FileError, InputError, count_of, reason_of

_LONGEST = 100_000_000  # bytes
_MAX_NUMBERS = 10_000_000  # of a text; each takes 40 bytes until it is in an array


def read_numbers(option: str, path: Path, row: Row) -> NDArray[np.float64]:
    """The numbers of a file in m, rad and s, shape (n, k), or the shape in a .npy file.

    option: names the file in errors; row: the columns of a row, for a file with names.

    Raises:
        FileError: The file cannot be read.
        InputError: It is too long, contains no numbers, or its names do not make a row.
    """
    try:
        content = file_bytes(path, _LONGEST)
    except OSError as error:
        raise FileError(str(path), reason_of(error)) from None
    if len(content) > _LONGEST:
        raise InputError(option, f"{path.name} has more than {_LONGEST // 1_000_000} MB")
    ending = path.suffix.lower()
    try:
        check_numbers(".npy" if ending == ".npy" else ".csv", content, _MAX_NUMBERS)
        return (_array if ending == ".npy" else _table)(option, path, content, row)
    except MemoryError:
        raise FileError(str(path), "cannot be read: out of memory") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(option, f"{path.name}: {error}") from None


def refuse_infinite(option: str, path: Path, rows: NDArray[np.float64]) -> None:
    """Refuse rows with a number that is not finite."""
    if not np.isfinite(rows).all():
        raise InputError(option, f"{path.name}: row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite")


def _array(option: str, path: Path, content: bytes, row: Row) -> NDArray[np.float64]:
    try:
        array = np.load(BytesIO(content), allow_pickle=False)
        if array.dtype.names is None:
            return _in_si(np.asarray(array, dtype=np.float64), row)
        fields = {name: np.asarray(array[name], dtype=np.float64).reshape(-1) for name in array.dtype.names}
    except (ValueError, TypeError, EOFError):
        raise InputError(option, f"{path.name} is not a .npy file of numbers") from None
    columns, scales = _columns(option, path, array.dtype.names, row)
    return np.column_stack([fields[array.dtype.names[column]] for column in columns]) * scales


def _columns(option: str, path: Path, names: Sequence[str], row: Row) -> tuple[list[int], NDArray[np.float64]]:
    try:
        columns, units = columns_of(names, row)
    except ValueError as error:
        raise InputError(option, f"{path.name}: {error}") from None
    return columns, np.array(units)


def _table(option: str, path: Path, content: bytes, row: Row) -> NDArray[np.float64]:
    """Read lines of numbers separated by commas, semicolons or blanks; the first line may have names."""
    lines = text_of(content).splitlines()
    try:
        head = head_of(lines, row.known)
    except ValueError as error:
        raise InputError(option, f"{path.name}: {error}") from None
    if head is None:
        raise InputError(option, f"{path.name} has no row of numbers")
    columns, scales = None, np.ones(1)
    if head.names is not None:
        columns, scales = _columns(option, path, head.names, row)
    rows: list[list[float]] = []
    for k, line in enumerate(lines[head.first :], start=head.first + 1):
        if not is_row(line):
            continue
        try:
            fields = fields_of(line, head.separator)
            if len(fields) == head.n_columns or columns is None:
                rows.append([number_of(fields[column], head) for column in columns or range(len(fields))])
        except ValueError:
            raise InputError(option, f"{path.name}:{k}: {line.strip()[:60]!r} is not a row of numbers") from None
        if len(fields) != head.n_columns:
            raise InputError(
                option, f"{path.name}:{k}: {count_of(len(fields), 'number')}, but {head.n_columns} in the row before"
            )
    table = np.array(rows, dtype=np.float64)
    return _in_si(table, row) if columns is None else table * scales


def _in_si(table: NDArray[np.float64], row: Row) -> NDArray[np.float64]:
    """Convert a table without names from each column's usual unit to m, rad or s."""
    units = np.array([one.unit for one in row.known])
    return table if (units == 1.0).all() or table.shape[-1:] != units.shape else table * units
