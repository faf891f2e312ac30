"""How a kernel is compiled: the decorators, their flags, and a disk cache that never serves stale code.

``kernel`` and ``routine`` mark functions that other kernels call; ``entry`` one that Python calls, whose machine code is
kept on disk.
Numba's own cache looks only at the file that holds the entry, not at the kernels it calls. Here the cache folder is named
by a hash of every source in this package, so a change anywhere in the kernels starts a fresh folder.
"""

import contextlib
import hashlib
import os
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

# 'nnan' and 'ninf' are left out on purpose: NaN in must give NaN out, and then an error, never a plausible number.
_FLAGS: dict[str, Any] = {"fastmath": {"contract", "reassoc", "nsz", "arcp"}, "error_model": "numpy", "nogil": True}
# Range reduction and compensated sums die of 'reassoc': with it, sin(1e5) is wrong by 4e-12 instead of 2e-16.
_EXACT_FLAGS: dict[str, Any] = {**_FLAGS, "fastmath": {"contract", "nsz"}}
# Kernels allocate nothing, so they need not count references: each array handed on would cost an atomic increment.
_COUNTS_NOTHING: dict[str, Any] = {"_nrt": False}
_UNUSED_FOLDER_DAYS = 30


def kernel(function):
    """Compile a formula: inlined wherever it is called, so that tuples of numbers stay in registers.

    Kernels count no references to arrays. An entry, which allocates and therefore does, must get no array back from one (a slice of
    its own, say): it would let go of what nobody took hold of. ``workspace`` is for that.
    """
    return njit(forceinline=True, **_COUNTS_NOTHING, **_FLAGS)(function)


def routine(function):
    """Compile a longer piece that works on rows: called, not inlined, which keeps compilation short."""
    return njit(**_COUNTS_NOTHING, **_FLAGS)(function)


def exact_kernel(function):
    """Compile without reassociation, for code that counts on the order of its operations."""
    return njit(forceinline=True, **_COUNTS_NOTHING, **_EXACT_FLAGS)(function)


def workspace(function):
    """Compile what makes arrays for an entry: besides entries the only kind that may return one."""
    return njit(**_FLAGS)(function)


def entry(function: Callable) -> Any:
    """Compile a function that Python calls, and keep its machine code on disk."""
    dispatcher: Any = njit(**_FLAGS)(function)
    if not config.DISABLE_JIT and cache_folder() is not None:  # pyright: ignore[reportAttributeAccessIssue]
        dispatcher._cache = _KernelCache(function)  # noqa: SLF001 - as njit(cache=True) sets Numba's own
    return dispatcher


@cache
def source_hash() -> str:
    """Hash of every kernel source, in hexadecimal."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> Path | None:
    """The folder of this version's machine code, or None where nothing can be written.

    ``NUMBA_CACHE_DIR`` is honoured; otherwise it lies in the user's own cache folder. Folders of other versions that
    nobody has used for a month are removed.
    """
    try:
        base = _base_folder()
        folder = base / f"kernels-{source_hash()}"
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        _remove_unused(base)
    except (OSError, RuntimeError):  # RuntimeError: a user without a home folder
        return None
    return folder if os.access(folder, os.W_OK) else None


def _base_folder() -> Path:
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"]) / "ulna"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "ulna" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "ulna"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ulna"


def _remove_unused(base: Path) -> None:
    oldest = time.time() - _UNUSED_FOLDER_DAYS * 86400
    for folder in base.glob("kernels-*"):
        if folder.stat().st_mtime < oldest:
            for file in folder.iterdir():
                file.unlink(missing_ok=True)
            folder.rmdir()


class _KernelLocator(_CacheLocator):
    """Tells Numba where an entry's machine code lies and what makes it stale."""

    def __init__(self, function):
        self._function = function

    def get_cache_path(self) -> Any:
        return str(cache_folder())

    def get_source_stamp(self) -> Any:
        return source_hash()

    def get_disambiguator(self):
        return self._function.__module__

    @classmethod
    def from_function(cls, py_func, py_file):  # noqa: ARG003 - Numba's signature
        return cls(py_func)


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes = (_KernelLocator,)


class _KernelCache(FunctionCache):
    _impl_class = _KernelCacheImpl

    def load_overload(self, sig, target_context):
        try:
            loaded = super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - a damaged file costs a compilation, and is replaced
            loaded = None
            with contextlib.suppress(OSError):
                self.flush()
        if loaded is None and sys.stderr is not None and sys.stderr.isatty():
            print(f"ulna: compiling {self._py_func.__name__} for this machine (once)", file=sys.stderr)  # noqa: T201
        return loaded

    def save_overload(self, sig, data):
        with contextlib.suppress(OSError):  # a full disk costs a compilation, not the answer
            super().save_overload(sig, data)
