"""Keeps a second process from writing to a map.

The operating system locks a file beside the map and frees it when the process ends, however it ends: a kill leaves no lock.
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from ulna.errors import FileError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Around what writes to the map at a path.

    Raises:
        FileError: Another process is writing to it, or the folder cannot be written to.
    """
    beside = path.with_name(f"{path.name}.lock")
    file = _locked_file(beside, path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()  # while it is locked: whoever has opened it sees that it is another file
        os.close(file)


def _locked_file(beside: Path, path: Path) -> int:
    while True:
        try:
            file = os.open(beside, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise FileError(str(path), f"the folder cannot be written to ({error.strerror})") from None
        try:
            _lock(file)
        except OSError:
            os.close(file)
            raise FileError(str(path), "another process is writing to this map; wait for it, or end it") from None
        if _same(file, beside):
            return file
        os.close(file)  # it was removed meanwhile by the process that had it


def _same(file: int, beside: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), beside.stat())
    except OSError:
        return False


def _lock(file: int) -> None:
    """Lock it, or raise an OSError at once if another process has."""
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    import msvcrt  # noqa: PLC0415 -- of Windows alone

    msvcrt.locking(file, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
