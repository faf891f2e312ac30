"""The machine code of entries on disk: a cache that never serves stale code.

Numba's own cache looks only at the file that holds the entry, not at the kernels it calls. Here the cache folder is named
by a hash of every source in this package, so a change anywhere in the kernels starts a fresh folder.
"""

import contextlib
import hashlib
import os
import sys
import time
import warnings
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from ulna.engine.private_folder import SharedFolderError, make_private

_UNUSED_FOLDER_DAYS = 30
announces = True
"""Whether a terminal is told of each entry that is compiled."""


@cache
def source_hash() -> str:
    """Hash of every kernel source, in hexadecimal."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> Path | None:
    """The folder of this version's machine code, or None where nothing can be written, or other users could write.

    ``NUMBA_CACHE_DIR`` is honoured; otherwise it lies in the user's own cache folder. Folders of other versions that
    nobody has used for a month are removed.

    Warns:
        RuntimeWarning: Other users could have put code there, so that it is not used.
    """
    try:
        base = _base_folder()
        folder = make_private(base, f"kernels-{source_hash()}")
        os.utime(folder)
        _remove_unused(base)
    except SharedFolderError as error:
        warnings.warn(f"ulna: compiled code is not kept, nor read: {error}", RuntimeWarning, stacklevel=2)
        return None
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
        with contextlib.suppress(OSError):  # another user's, or another process removes it too: it stays, or is gone already
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


class KernelCache(FunctionCache):
    """Numba's cache of one entry, in our folder."""

    _impl_class = _KernelCacheImpl

    def load_overload(self, sig, target_context):
        """The machine code of a signature, or None, which means that it is compiled now: a terminal is told."""
        try:
            loaded = super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - a damaged file costs a compilation, and is replaced
            loaded = None
            with contextlib.suppress(OSError):
                self.flush()
        if loaded is None and announces and sys.stderr is not None and sys.stderr.isatty():
            print(f"ulna: compiling {self._py_func.__name__} for this machine (once)", file=sys.stderr)  # noqa: T201
        return loaded

    def save_overload(self, sig, data):
        """Keep the machine code of a signature."""
        with contextlib.suppress(OSError):  # a full disk costs a compilation, not the answer
            super().save_overload(sig, data)
