"""Provides entries: machine code of a wheel if it contains some, otherwise code that Numba compiles.

An entry is a function that Python calls. It owns its workspaces, the scratch memory, and runs kernels over a batch, eight
problems at a time. The entries of a folder, such as ``ulna/kinematics``, are in its package ``entries``. A caller imports a
module of it and calls the function: ``from ulna.kinematics.entries import forward``, then ``forward.forward_batch(chain, q,
out)``. The import loads nothing. The module, with its kernels and the compiler, is loaded at the function's first use, and not at
all if it was compiled ahead.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from ulna.engine.ahead import ahead_entry, asks_for_python
from ulna.errors import UlnaError

EntryT = TypeVar("EntryT")


def ready(entry: EntryT) -> EntryT:
    """Return an entry with its machine code; one of low latency is compiled now, or loaded from disk."""
    compile_now = getattr(entry, "compile_now", None)
    if compile_now is not None:
        compile_now()
    return entry


def modules_of(package: str) -> Callable[[str], ModuleType]:
    """The ``__getattr__`` of a package of entries: it makes a stand-in for a module, without loading it.

    ``_resolve`` looks a name up at its first use. Afterwards it is an attribute of the stand-in, a plain module, so access is as
    fast as in any module.
    """

    def module(name: str) -> ModuleType:
        path = f"{package}.{name}"
        if name.startswith("__") or find_spec(path) is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        stand_in = ModuleType(path)
        stand_in.__getattr__ = partial(_resolve, stand_in)  # type: ignore[method-assign] - of modules it is looked up in the instance
        return stand_in

    return module


@dataclass(frozen=True)
class Entries:
    """The entries of all folders of a package, in their packages ``entries``.

    An entry's name is its module in the package and its function, such as ``"kinematics.entries.forward.forward_one"``.
    """

    package: str

    def marked(self, name: str) -> Any:
        """An entry by its name, compiled or not.

        Raises:
            LookupError: There is no such entry.
        """
        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        path, _, function = f"{self.package}.{name}".rpartition(".")
        try:
            found = getattr(importlib.import_module(path), function, None)
        except ModuleNotFoundError as error:
            if not f"{path}.".startswith(f"{error.name}."):
                raise
            found = None
        if found not in ENTRIES:
            raise LookupError(f"{self.package} has no entry {name!r}")
        return found

    def names(self) -> list[str]:
        """The names of all entries. Imports all their modules, and so the compiler."""
        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        for module in self.modules():
            importlib.import_module(module)
        within = f"{self.package}."
        return [calls.name.removeprefix(within) for calls in ENTRIES.values() if calls.name.startswith(within)]

    def modules(self) -> list[str]:
        """The modules of all packages ``entries``, by their full names."""
        folder = Path(importlib.import_module(self.package).__path__[0])
        files = (file.relative_to(folder.parent) for file in sorted(folder.rglob("entries/*.py")))
        return [".".join(file.with_suffix("").parts) for file in files if file.stem != "__init__"]

    def are_together(self, name: str) -> bool:
        """Whether the entry is compiled in one process with others that call the same long kernels (``COMPILED_TOGETHER``)."""
        room = f"{self.package}.{name}".rsplit(".", 2)[0]
        return getattr(importlib.import_module(room), "COMPILED_TOGETHER", False)


def _resolve(stand_in: ModuleType, name: str) -> Any:
    """Resolve a name of a stand-in: an entry compiled ahead, otherwise the attribute of the module, which is loaded.

    Raises:
        AttributeError: The module has no such name.
        UlnaError: The wheel's machine code cannot be used, or neither machine code nor Numba is installed.
    """
    if name.startswith("__"):  # tools look these up in any module
        raise AttributeError(f"module {stand_in.__name__!r} has no attribute {name!r}")
    found = ahead_entry(stand_in.__name__, name)
    if found is None:
        from ulna.engine.decorators import ENTRIES, compiler  # noqa: PLC0415 - it loads the compiler

        found = getattr(importlib.import_module(stand_in.__name__), name)
        if compiler is None and not asks_for_python() and any(found is entry for entry in ENTRIES):  # it takes 1000 times as long
            raise UlnaError("there is neither machine code nor a compiler: pip install numba, or install a wheel of ulna again")
    setattr(stand_in, name, found)
    return found
