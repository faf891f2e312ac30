"""Compiles a routine once, for every entry that calls it.

Numba copies the callees of a function into each of its callers, and LLVM optimizes every copy. For a long routine (the distance
of two convex bodies) with many callers, that takes most of the time of compiling. Here a caller contains only the routine's name.
The routine's machine code is stored on disk like that of an entry. A caller that is loaded from disk loads it first, by Numba's
``reload_init``.
"""

import hashlib
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba.core import cgutils

from ulna.engine.sources import sources_hash


class Shared(NamedTuple):
    """A routine that is compiled once for some argument types: its dispatcher, and the symbol that callers use."""

    dispatcher: Any
    types: tuple
    symbol: str

    @property
    def compiled(self) -> Any:
        """Numba's compilation."""
        return self.dispatcher.overloads[self.types]


SHARED: dict[str, Shared] = {}
"""By symbol: the routines that code compiled or loaded in this process calls."""
DISPATCHERS: list[Any] = []
"""The dispatchers of all shared routines."""


def share(dispatcher: Any) -> None:
    """Let compiled code call a dispatcher by its symbol, instead of copying it."""
    DISPATCHERS.append(dispatcher)
    dispatcher.get_overload = lambda types: _shared(dispatcher, tuple(types)).symbol


def _shared(dispatcher: Any, types: tuple) -> Shared:
    """A routine compiled for some types, registered with LLVM and Numba at its first use."""
    symbol = _symbol(dispatcher.py_func, types)
    if symbol not in SHARED:
        shared = Shared(dispatcher, types, symbol)
        compiled = shared.compiled
        llvm.add_symbol(symbol, compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))
        compiled.target_context.insert_func_defn([(_call(shared), symbol, types)])
        SHARED[symbol] = shared
    return SHARED[symbol]


def _symbol(function: Callable, types: tuple) -> str:
    text = f"{sources_hash(function.__code__.co_filename)} {types}"
    return f"ulna_{function.__module__.replace('.', '_')}_{function.__name__}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _call(shared: Shared) -> Callable:
    """The function that writes a call of the routine, in Numba's form."""
    module, name = shared.dispatcher.py_func.__module__, shared.dispatcher.py_func.__name__

    def call(context, builder, _, arguments):
        compiled, convention = shared.compiled, context.call_conv
        context.active_code_library._reload_init.add(Reload(module, name, shared.types))  # noqa: SLF001 - as typed_passes does
        kind = convention.get_function_type(compiled.signature.return_type, compiled.signature.args)
        function = cgutils.get_or_insert_function(builder.module, kind, shared.symbol)
        status, value = convention.call_function(
            builder, function, compiled.signature.return_type, compiled.signature.args, arguments
        )
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return value

    return call


class Reload(NamedTuple):
    """Loads or recompiles a routine before a caller is loaded from disk; a tuple, stored with the caller."""

    module: str
    name: str
    types: tuple

    def __call__(self) -> None:
        """Load the routine."""
        dispatcher = getattr(import_module(self.module), self.name).within
        dispatcher.compile(self.types)
        _shared(dispatcher, self.types)
