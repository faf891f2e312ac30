"""Finds entries by name, whoever provides their machine code.

An entry is a function of the drivers that Python calls. Callers know its name and its arguments, not where its machine code comes
from: that is decided in ``Entries.find`` alone. Until an entry is asked for, nothing loads the compiler.
"""

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ulna.engine.ahead import ahead_entry
from ulna.errors import UlnaError


@dataclass(frozen=True)
class Entries:
    """The entries of a package of drivers.

    Attributes:
        package: The package's name. Its modules hold the entries.
        compiled_together: Modules whose entries call the same long kernels: compiled in one process, these are compiled once.
    """

    package: str
    compiled_together: frozenset[str] = frozenset()

    def find(self, name: str) -> Callable[..., Any]:
        """An entry by its module and function, such as ``"forward.forward_one"``, ready to be called.

        Its machine code was compiled ahead, if a wheel brought it; otherwise it is compiled now, or loaded from disk.

        Raises:
            LookupError: There is no such entry.
            UlnaError: The wheel's machine code cannot be used, or neither machine code nor Numba is installed.
        """
        found = ahead_entry(self.package, name)
        if found is not None:
            return found
        from ulna.engine.decorators import callable_entry, compiler  # noqa: PLC0415 - it loads the compiler

        marked = self.marked(name)
        asked_for_python = os.environ.get("NUMBA_DISABLE_JIT", "0") not in {"", "0"}
        if compiler is None and not asked_for_python:  # it takes a thousand times as long
            raise UlnaError("there is neither machine code nor a compiler: pip install numba, or install a wheel of ulna again")
        return callable_entry(marked)

    def marked(self, name: str) -> Any:
        """The function that the drivers mark as an entry; none of its machine code need be there yet.

        Raises:
            LookupError: There is no such entry.
        """
        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        module, _, function = name.partition(".")
        found = getattr(importlib.import_module(f"{self.package}.{module}"), function, None)
        if found not in ENTRIES:
            raise LookupError(f"{self.package} has no entry {name!r}")
        return found

    def names(self) -> list[str]:
        """The names of all entries. Imports all modules of the package, and so the compiler."""
        import pkgutil  # noqa: PLC0415 - `import ulna` need not wait for it

        from ulna.engine.decorators import ENTRIES  # noqa: PLC0415 - it loads the compiler

        for module in pkgutil.iter_modules(importlib.import_module(self.package).__path__):
            importlib.import_module(f"{self.package}.{module.name}")
        within = f"{self.package}."
        return [calls.name.removeprefix(within) for calls in ENTRIES.values() if calls.name.startswith(within)]
