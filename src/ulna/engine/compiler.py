"""Gives functions to Numba, with the lanes taught and our cache set.

Nothing else need be imported to compile, and nothing that is compiled ahead imports it.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba import njit, types
from numba.core import config

import ulna.engine.lane_lowering
import ulna.engine.lane_operators
import ulna.engine.lane_rows  # noqa: F401 - for their effect: Numba knows the number that is eight numbers
from ulna.engine.cache import KernelCache, RoutineCache, cache_folder
from ulna.engine.interrupts import interrupts_deferred
from ulna.engine.pipelines import IRCompiler, WholeCompiler
from ulna.engine.shared import share
from ulna.engine.signatures import Array, Group, Kind, Signature

_njit: Any = njit  # its annotations leave out some of our flags
_ELEMENTS = {"bool": "boolean"}  # as Numba calls them, where the name is another than NumPy's


def is_disabled() -> bool:
    """Whether kernels run as plain Python (``NUMBA_DISABLE_JIT=1``)."""
    return bool(config.DISABLE_JIT)  # pyright: ignore[reportAttributeAccessIssue]


def numba_types(signature: Signature) -> tuple[types.Type, ...]:
    """A signature in Numba's types."""
    return tuple(map(_numba_type, signature))


def compiled(function: Callable, flags: dict[str, Any]) -> Any:
    """A function that Numba compiles when it is first called, with flags of ours.

    Compiled code calls a twin of it, of which no machine code is made (``without_code``).
    """
    dispatcher = _njit(pipeline_class=WholeCompiler, **flags)(function)
    if not is_disabled():
        _let_callers_use(_njit(pipeline_class=IRCompiler, no_cpython_wrapper=True, **flags)(function), dispatcher)
    return dispatcher


def compiled_once(function: Callable, flags: dict[str, Any]) -> Any:
    """The same, compiled once for all that call it (``shared``), and kept on disk."""
    dispatcher = _njit(**flags)(function)
    if not is_disabled():
        within = _njit(pipeline_class=WholeCompiler, no_cpython_wrapper=True, **flags)(function)
        folder = cache_folder()
        if folder is not None:
            within._cache = RoutineCache(function, folder)  # noqa: SLF001 - as njit(cache=True) sets Numba's own
        share(within)
        _let_callers_use(within, dispatcher)
    return dispatcher


def _let_callers_use(within: Any, dispatcher: Any) -> None:
    """Let code that is compiled call ``within`` where it names a dispatcher.

    Numba would compile a function once more for each whole number that it is called with in the source. LLVM finds such
    constants itself, where it copies the function into its caller.
    """
    dispatcher.within = within
    dispatcher.get_call_template = lambda args, kws: within.get_call_template(
        tuple(map(_without_number, args)), {name: _without_number(kind) for name, kind in kws.items()}
    )
    dispatcher.get_overload = within.get_overload


def _without_number(kind: Any) -> Any:
    return types.unliteral(kind) if isinstance(kind, types.IntegerLiteral) else kind


def compiled_entry(function: Callable, flags: dict[str, Any], may_compile: Callable[[Any], None]) -> Any:
    """The same, kept on disk; ``may_compile`` raises where it may not be compiled now."""
    dispatcher = _njit(pipeline_class=WholeCompiler, **flags)(function)
    if is_disabled():
        return dispatcher
    folder = cache_folder()
    if folder is not None:
        dispatcher._cache = KernelCache(function, folder)  # noqa: SLF001 - as njit(cache=True) sets Numba's own
    _ask_before_compiling(dispatcher, may_compile)
    # Ctrl-C waits while an entry is compiled or loaded from disk.
    dispatcher.compile = _garbage_kept()(interrupts_deferred()(dispatcher.compile))
    return dispatcher


def _ask_before_compiling(dispatcher: Any, may_compile: Callable[[Any], None]) -> None:
    """Test whether this thread may compile, where Numba has found no machine code for a call and before it takes its lock."""
    compile_for = dispatcher._compile_for_args  # noqa: SLF001 - the only place before the lock

    def compile_if_permitted(*arguments: Any, **named: Any) -> Any:
        may_compile(dispatcher)
        return compile_for(*arguments, **named)

    dispatcher._compile_for_args = compile_if_permitted  # noqa: SLF001


@contextmanager
def _garbage_kept() -> Iterator[None]:
    """Within it the garbage collector does not run: a compilation makes millions of objects, nearly all of them kept."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _numba_type(kind: Kind) -> types.Type:
    if isinstance(kind, Group):
        return types.Tuple(tuple(map(_numba_type, kind.parts)))
    if isinstance(kind, Array):
        element = getattr(types, _ELEMENTS.get(kind.element, kind.element))
        return types.Array(element, kind.dimensions, "C", readonly=kind.constant)
    return getattr(types, kind.name)
