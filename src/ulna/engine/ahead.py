"""Finds the machine code of a wheel, compiled ahead for a few levels of CPU.

It is in the folder ``machine_code`` next to this file, the only place that is searched. There is a library for each level, with
the entries that ``emit`` wrote, and ``index.json``, their table of contents. A clone has no such folder: there Numba compiles.
"""

import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from ulna.engine.private_folder import cache_base, private_folder
from ulna.errors import FileError, InputError, UlnaError

FOLDER = Path(__file__).with_name("machine_code")
INDEX = "index.json"
VARIABLE = "ULNA_CPU"
NATIVE = "native"
_SOURCE = "a copy of the repository, where Numba compiles for this machine: pip install -e . in it"


def ahead_entry(module: str, function: str) -> Callable[..., Any] | None:
    """A function of an entries module from this CPU's library; None if Numba compiles, or for no entry."""
    library = _library() if is_ahead() else None
    if library is None or not module.startswith(f"{library.package}."):
        return None
    return library.find(f"{module.removeprefix(library.package)[1:]}.{function}")


def is_ahead() -> bool:
    """Whether machine code compiled ahead is used: it exists, and neither Python nor this CPU's own code was requested.

    ``NUMBA_DISABLE_JIT=1`` requests plain Python, ``ULNA_CPU=native`` code that Numba compiles for this CPU.
    """
    return not asks_for_python() and os.environ.get(VARIABLE) != NATIVE and _is_there()


def asks_for_python() -> bool:
    """Whether ``NUMBA_DISABLE_JIT=1`` requests plain Python."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in {"", "0"}


@cache
def extension() -> Any:
    """The C extension of a wheel (``native``), which calls machine code; None in an installation without it."""
    try:
        from ulna.engine import _calls  # noqa: PLC0415 # pyright: ignore[reportAttributeAccessIssue] - a clone has none
    except ImportError:
        return None
    return _calls


def level() -> str:
    """The level of CPU whose machine code is used, such as ``x86-64-v3``; valid only if ``is_ahead``."""
    return _library().level


class Library:
    """The machine code of one level.

    Attributes:
        level: Its name.
        package: The package of its entries.
    """

    def __init__(self, folder: Path, index: dict[str, Any], name: str) -> None:
        import ctypes  # noqa: PLC0415 - a clone does not need it

        self.level, self.package = name, index["package"]
        self._entries, self._made = index["entries"], {}
        self._file = folder / index["levels"][name]["file"]
        try:
            whole = _is_whole(
                self._file, index["levels"][name]["size"], index["levels"][name]["sha256"]
            )  # loading a damaged library may end the process
            self._library: Any = ctypes.CDLL(str(self._file)) if whole else None
        except OSError as error:
            raise _damaged(self._file, error) from None
        if self._library is None:
            raise _damaged(self._file, "it is not the wheel's: its size or its hash differs")

    def find(self, name: str) -> Callable[..., Any] | None:
        """An entry of the library, created once; or None."""
        entry = self._entries.get(name)
        if entry is not None and name not in self._made:
            overloads = tuple((self._address(one["symbol"]), one["signature"]) for one in entry["overloads"])
            made = extension().make_entry(name, overloads, entry["result"], entry["releases_lock"])
            self._made.setdefault(name, made)
        return self._made.get(name)

    def _address(self, symbol: str) -> int:
        import ctypes  # noqa: PLC0415 - a clone does not need it

        try:
            return ctypes.cast(self._library[symbol], ctypes.c_void_p).value or 0
        except AttributeError as error:
            raise _damaged(self._file, error) from None


def _is_whole(file: Path, size: int, sha256: str) -> bool:
    """Whether a library has the content in the wheel's index; the hash is computed once per machine.

    Afterwards an empty file in the private cache folder records the checked file in its name: hash, device, inode, size and
    modification time. Without such a folder, the hash is computed each time.
    """
    status = file.stat()
    if status.st_size != size:
        return False
    mark = f"{sha256}-{status.st_dev:x}-{status.st_ino:x}-{status.st_mtime_ns:x}"
    try:
        with private_folder(cache_base()) as base, base.folder("libraries") as marks:
            return marks.has(mark) or (_hash_is(file, sha256) and marks.note(mark))
    except (OSError, RuntimeError):  # RuntimeError: a user without a home folder
        return _hash_is(file, sha256)


def _hash_is(file: Path, sha256: str) -> bool:
    import hashlib  # noqa: PLC0415 - needed once per machine

    return hashlib.sha256(file.read_bytes()).hexdigest() == sha256


def load_library(folder: Path, wanted: str) -> Library:
    """The library of a level; with an empty ``wanted`` the highest level that this CPU supports."""
    try:
        index = _checked(json.loads((folder / INDEX).read_text(encoding="utf-8")))
        levels = {name: level["needs"] for name, level in index["levels"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise _damaged(folder / INDEX, error) from None
    if extension() is None:
        raise _damaged(folder, "its extension in C is missing, or cannot be loaded")
    has = extension().x86_level()
    possible = [name for name, needed in levels.items() if needed <= has]
    if not possible:
        raise UlnaError(f"this wheel needs a CPU of the level {min(levels)} at least, which this is not; use {_SOURCE}")
    if wanted and wanted not in possible:
        raise InputError(VARIABLE, f"{wanted!r}; the environment variable must be one of {', '.join([*possible, NATIVE])}")
    return Library(folder, index, wanted or possible[-1])


def _checked(index: Any) -> dict[str, Any]:
    """Check the form of the index that ``hatch_build`` writes, so that later code can rely on it.

    Raises:
        KeyError, TypeError, AttributeError: The form is wrong.
    """
    _check_kinds(index, {"package": str, "levels": dict, "entries": dict})
    for level in index["levels"].values():
        _check_kinds(level, {"needs": int, "file": str, "size": int, "sha256": str})
    for entry in index["entries"].values():
        _check_kinds(entry, {"overloads": list, "result": str, "releases_lock": bool})
        for overload in entry["overloads"]:
            _check_kinds(overload, {"symbol": str, "signature": str})
    return index


def _check_kinds(table: dict[str, Any], kinds: dict[str, type]) -> None:
    for name, kind in kinds.items():
        if not isinstance(table[name], kind):
            raise TypeError(f"{name} is not of type {kind.__name__}")


@cache
def _is_there() -> bool:
    return FOLDER.is_dir()


@cache
def _library() -> Library:
    return load_library(FOLDER, os.environ.get(VARIABLE, "").strip())


def _damaged(file: Path, error: object) -> FileError:
    return FileError(str(file), f"the machine code of this wheel cannot be loaded ({error}); install it again, or use {_SOURCE}")
