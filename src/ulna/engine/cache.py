"""Stores the machine code of entries on disk, and never loads code of other sources.

**The idea.** A file's name is a hash of everything that its content depends on. So a file is never out of date: after any change
another name is searched, which does not exist yet. Loading compares nothing and needs no index. Processes, clones and versions of
Ulna that share a folder do not disturb each other. The names consist of three hashes:

1. The folder, ``kernels-<hash>``: the versions of Python, Numba, llvmlite and NumPy, Numba's settings, missing names of Numba
   (``numba_private``), and the text of the engine's own compiling modules (``compiler_hash``).
2. The file, ``<entry>-<hash>``: the text of the entry's file and of every file that it takes names from, directly or through
   others (``sources``). Each text is read when it is loaded, so an edit in a running program changes neither code nor name. A
   change to the kernels of pictures does not affect a pose.
3. The end of the file's name: the types of the arguments, and the processor with its features, as Numba states them.

Numba's own cache uses only the entry's file as its key, by size and modification time. It would load the old code after a
change in a kernel that the entry calls, or after an upgrade that set an older time.

A call of an entry without machine code in this process goes to ``load_overload``, which reads the file of its name. If that is
missing or damaged, Numba compiles, and ``save_overload`` writes the file, as a whole or not at all. A shared routine (``shared``)
has a file of its own, which is loaded before those of its callers. Files that were not used for a month are removed.

Anyone who can write into the folder can have code executed. So it is opened once and checked while it is open. Its files are
opened by that descriptor (``private_folder``).
"""

import contextlib
import hashlib
import pickle
import platform
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba import config

from ulna.engine.announcements import compilation_begins, compilation_ended
from ulna.engine.numba_private import (
    CacheLocator,
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    turned_off,
)
from ulna.engine.private_folder import PrivateFolder, SharedFolderError, cache_base, private_folder
from ulna.engine.second_process import is_compiled_elsewhere
from ulna.engine.sources import sources_hash

_UNUSED_DAYS = 30
_SETTINGS = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")


@cache
def compiler_hash() -> str:
    """Hash, in hexadecimal, of everything that all machine code depends on: the compiler, its settings, and our decorators."""
    versions = platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__
    settings = (str(getattr(config, name, None)) for name in _SETTINGS)
    ours = sources_hash(str(Path(__file__).with_name("decorators.py")))
    return hashlib.sha256("\0".join((*versions, *settings, *turned_off(), ours)).encode()).hexdigest()[:16]


@cache
def cache_folder() -> PrivateFolder | None:
    """The folder of this compiler's machine code; None if it cannot be written, or if other users could write there.

    It is in ``NUMBA_CACHE_DIR``, or else in the user's own cache folder. Files, and folders of other compilers, are removed if
    they were not used for a month.

    Warns:
        RuntimeWarning: Other users could have put code there, so the folder is not used.
    """
    try:
        with private_folder(cache_base()) as base:
            folder = base.folder(f"kernels-{compiler_hash()}")
            folder.touch()
            base.remove_unused_folders("kernels-", _UNUSED_DAYS)
        folder.remove_unused(_UNUSED_DAYS)
    except SharedFolderError as error:
        warnings.warn(f"ulna: the cache of compiled code is not used: {error}", RuntimeWarning, stacklevel=2)
        return None
    except (OSError, RuntimeError):  # RuntimeError: a user without a home folder
        return None
    return folder


class _Locator(CacheLocator):
    """Names an entry's files for Numba."""

    def __init__(self, function):
        self._function = function

    def get_cache_path(self) -> Any:
        return ""  # not used: files are opened in the open folder

    def ensure_cache_path(self) -> None:
        pass

    def get_source_stamp(self) -> Any:
        return None  # the names of the files depend on the sources already

    def get_disambiguator(self) -> Any:
        return f"{self._function.__module__}-{sources_hash(self._function.__code__.co_filename)}"

    @classmethod
    def from_function(cls, py_func, py_file):  # noqa: ARG003 - Numba's signature
        return cls(py_func)


class _CacheImpl(CompileResultCacheImpl):
    _locator_classes = (_Locator,)


class _Files(IndexDataCacheFile):
    """A file for each signature and processor.

    Numba numbers the files and keeps an index of them. Two processes that write at once can corrupt that index.
    """

    def __init__(self, folder: PrivateFolder, filename_base: str) -> None:
        super().__init__("", filename_base, None)
        self._folder = folder

    def load(self, key):
        """The machine code of a key, or None; marks its file as used now."""
        with contextlib.suppress(FileNotFoundError):
            return pickle.loads(self._folder.read(self.name_of(key)))  # noqa: S301 - only this user can write there
        return None

    def save(self, key, data):
        """Save the machine code of a key: the types of the arguments, the processor, and hashes of the function's code."""
        self._folder.write(self.name_of(key), self._dump(data))

    def name_of(self, key) -> str:
        """The name of the file of a key."""
        return self._data_name_pattern.replace("{number:d}", hashlib.sha256(repr(key).encode()).hexdigest()[:16])


class RoutineCache(FunctionCache):
    """Numba's cache of one shared routine, in our folder."""

    _impl_class = _CacheImpl

    def __init__(self, py_func, folder: PrivateFolder):
        super().__init__(py_func)
        self._folder = folder
        self._cache_file = _Files(folder, self._impl.filename_base)

    def load_overload(self, sig, target_context):
        """The machine code of a signature from the cache, or None: then Numba compiles it."""
        with contextlib.suppress(Exception):  # a damaged file is compiled again and replaced
            return super().load_overload(sig, target_context)
        return None

    def file_of(self, sig, target_context) -> str:
        """The name of the file of a signature."""
        return self._cache_file.name_of(self._index_key(sig, target_context.codegen()))

    def save_overload(self, sig, data):
        """Save the machine code of a compiled signature; generate it now if that has not happened yet."""
        data.library.get_pointer_to_function(data.fndesc.llvm_func_name)
        with contextlib.suppress(OSError):  # on a full disk the code is used, but not saved
            super().save_overload(sig, data)


class KernelCache(RoutineCache):
    """Numba's cache of one entry, in our folder, with announced compilations."""

    def load_overload(self, sig, target_context):
        """The machine code of a signature from the cache, or None: then Numba compiles it, which is announced."""
        loaded = super().load_overload(sig, target_context)
        if loaded is None:
            compilation_begins(self._py_func.__name__)
            if is_compiled_elsewhere(self.file_of(sig, target_context), self._folder):
                loaded = super().load_overload(sig, target_context)
            if loaded is not None:
                compilation_ended(self._py_func.__name__)
        return loaded

    def save_overload(self, sig, data):
        """Save the machine code of a compiled signature."""
        compilation_ended(self._py_func.__name__)
        super().save_overload(sig, data)
