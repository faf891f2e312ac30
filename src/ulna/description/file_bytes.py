"""Reads and writes the bytes of files, writes tables of numbers, and reads JSON from an untrusted source.

Reading a pipe without a writer ends after a time limit. A file is written completely or not at all.
"""

import json
import os
import re
import select
import stat
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import FileError, reason_of

PIPE_PATIENCE_S = 10.0
_AT_ONCE = 1 << 20


def file_bytes(path: str | Path, most: int) -> bytes:
    """The bytes of a file, a device or a pipe, at most ``most`` + 1 of them."""
    with open(path, "rb", opener=_without_waiting) as file:
        if stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
            return _pipe_bytes(file.fileno(), most)
        if hasattr(os, "O_NONBLOCK"):
            os.set_blocking(file.fileno(), True)
        return _bytes_of(file, most)


def regular_file_bytes(path: str | Path, most: int) -> bytes:
    """The bytes of a regular file only, for a path from an untrusted description."""
    with open(path, "rb", opener=_without_waiting) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(22, "not a regular file", str(path))
        return _bytes_of(file, most)


def write_whole(path: Path, content: bytes) -> None:
    """Write a temporary file and rename it, so that the old file exists until the new one is complete.

    For a symbolic link, the target is replaced. A device or a pipe is written directly.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        target.write_bytes(content)
        return
    import uuid  # noqa: PLC0415 - reading does not need it

    beside = target.with_name(f".{uuid.uuid4().hex}.part")
    try:
        beside.write_bytes(content)
        if target.exists():
            beside.chmod(stat.S_IMODE(target.stat().st_mode))
        beside.replace(target)
    finally:
        beside.unlink(missing_ok=True)


def write_table(path: str | Path, names: Sequence[str], rows: NDArray[np.float64]) -> None:
    """Write a line of names, then a line for each row, shape (n, k), with all digits of every number."""
    quoted = [f'"{name.replace(chr(34), 2 * chr(34))}"' if re.search('[",\\s]', name) else name for name in names]
    lines = [",".join(quoted), *(",".join(map(repr, row)) for row in rows.tolist())]
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise FileError(str(path), reason_of(error, missing="no such folder")) from None


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _bytes_of(file: IO[bytes], most: int) -> bytes:
    """Read at most ``most`` + 1 bytes without allocating more memory than needed: ``read(n)`` allocates n bytes first."""
    known = min(most, os.fstat(file.fileno()).st_size)
    read = file.read(known + 1)
    if len(read) <= known:
        return read
    parts, n = [read], len(read)  # a device, or a growing file
    while n <= most and (part := file.read(min(_AT_ONCE, most + 1 - n))):
        parts.append(part)
        n += len(part)
    return b"".join(parts)


def _pipe_bytes(pipe: int, most: int) -> bytes:
    read = bytearray()
    while len(read) <= most:
        end = time.monotonic() + PIPE_PATIENCE_S
        while not select.select([pipe], [], [], max(0.0, end - time.monotonic()))[0]:
            if time.monotonic() >= end:
                raise OSError(110, f"a pipe, and nothing came through it for {PIPE_PATIENCE_S:g} s")
        chunk = os.read(pipe, _AT_ONCE)
        if not chunk:
            break
        read += chunk
    return bytes(read[: most + 1])


_MAX_VALUES, _MAX_CONTAINERS = 12_000_000, 3_000_000  # of a JSON text: numbers and texts, and lists and objects, 90 bytes each
_MAX_LEVELS = 50  # of nested lists: our own files have about ten; Python's recursion ends near a thousand


def json_value(text: str | bytes, **options: Any) -> Any:
    """The value of a JSON text.

    Raises:
        ValueError: It is not JSON, or has too many values or levels.
    """
    comma, list_, object_ = (",", "[", "{") if isinstance(text, str) else (b",", b"[", b"{")
    n_values, n_containers = text.count(comma), text.count(list_) + text.count(object_)  # type: ignore[arg-type]
    if n_values > _MAX_VALUES or n_containers > _MAX_CONTAINERS:
        raise ValueError(f"it has more than {_MAX_VALUES} values, or more than {_MAX_CONTAINERS} lists and objects")
    try:
        value = json.loads(text, **options)
    except RecursionError:
        raise ValueError(f"it has more than {_MAX_LEVELS} levels") from None
    level, n_levels = [value], 0
    while level:
        level = [inner for outer in level for inner in _inside(outer) if isinstance(inner, (dict, list))]
        n_levels += 1
        if n_levels > _MAX_LEVELS:
            raise ValueError(f"it has more than {_MAX_LEVELS} levels")
    return value


def _inside(value: Any) -> Any:
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
