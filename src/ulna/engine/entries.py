"""Provides the entries of drivers: machine code of a wheel where it brings some, else what Numba compiles.

An entry is a function of the drivers that Python calls. A caller imports the driver's module and calls the function:
``from ulna.drivers import forward``, then ``forward.forward_batch(chain, q, out)``. The import loads nothing. The module, with
its kernels and the compiler, is loaded when the function is first used, and not at all where this was compiled ahead.
"""

import importlib
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from types import ModuleType
from typing import Any, TypeVar

from ulna.engine.ahead import ahead_entry, asks_for_python
from ulna.errors import UlnaError

EntryT = TypeVar("EntryT")


def ready(entry: EntryT) -> EntryT:
    """An entry, its machine code there: one of low latency is compiled now, or loaded from disk, for its one signature."""
    compile_now = getattr(entry, "compile_now", None)
    if compile_now is not None:
        compile_now()
    return entry


@dataclass(frozen=True)
class Entries:
    """The entries of a package of drivers.

    Attributes:
        package: The package's name. Its modules hold the entries.
        compiled_together: Modules whose entries call the same long kernels: compiled in one process, these are compiled once.
    """

    package: str
    compiled_together: frozenset[str] = frozenset()

    def module(self, name: str) -> ModuleType:
        """A stand-in for a module of the package, of which nothing is loaded yet: ``__getattr__`` of the package.

        A name is looked up by ``_taken`` when it is first used. Then it is an attribute of the stand-in, a plain module, so that
        it is found there as fast as in any.

        Raises:
            AttributeError: There is no such module.
        """
        path = f"{self.package}.{name}"
        if name.startswith("__") or find_spec(path) is None:
            raise AttributeError(f"module {self.package!r} has no attribute {name!r}")
        module = ModuleType(path)
        module.__getattr__ = partial(_taken, module)  # type: ignore[method-assign] - of modules it is looked up in the instance
        return module

    def marked(self, name: str) -> Any:
        """An entry by its name, such as ``"forward.forward_one"`` or ``"planning.search.plan_slice"``, compiled or not.

        Raises:
            LookupError: There is no such entry.
        """
        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        path, _, function = f"{self.package}.{name}".rpartition(".")
        try:
            found = getattr(importlib.import_module(path), function, None)
        except ModuleNotFoundError as error:
            if error.name != path:
                raise
            found = None
        if found not in ENTRIES:
            raise LookupError(f"{self.package} has no entry {name!r}")
        return found

    def names(self) -> list[str]:
        """The names of all entries. Imports all modules of the package, and so the compiler."""
        import pkgutil  # noqa: PLC0415 - `import ulna` need not wait for it

        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        within = f"{self.package}."
        for module in pkgutil.walk_packages(importlib.import_module(self.package).__path__, within):
            importlib.import_module(module.name)
        return [calls.name.removeprefix(within) for calls in ENTRIES.values() if calls.name.startswith(within)]


def _taken(stand_in: ModuleType, name: str) -> Any:
    """What is taken from a stand-in for a module: an entry compiled ahead, else what the module has, which is loaded for it.

    Raises:
        AttributeError: The module has nothing of this name.
        UlnaError: The wheel's machine code cannot be used, or neither machine code nor Numba is installed.
    """
    if name.startswith("__"):  # what tools look for in any module
        raise AttributeError(f"module {stand_in.__name__!r} has no attribute {name!r}")
    found = ahead_entry(stand_in.__name__, name)
    if found is None:
        from ulna.engine.decorators import ENTRIES, compiler  # noqa: PLC0415 - it loads the compiler

        found = getattr(importlib.import_module(stand_in.__name__), name)
        if compiler is None and not asks_for_python() and any(found is entry for entry in ENTRIES):  # it takes 1000 times as long
            raise UlnaError("there is neither machine code nor a compiler: pip install numba, or install a wheel of ulna again")
    setattr(stand_in, name, found)
    return found
