"""Passes functions to Numba, with the lanes registered and our cache installed.

This module is sufficient to compile, and code compiled ahead does not import it. Names missing in the installed version of Numba
(``numba_private``) are avoided.

Ctrl-C waits until the compiler is done. Python raises ``KeyboardInterrupt`` between any two of its instructions. Within LLVM's
callbacks it is lost, and the program continues. Between taking and releasing llvmlite's lock it leaves the lock taken, and the
program waits forever.
"""

import gc
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, cast

from numba import config, from_dtype, njit, types

import ulna.engine.lane_lowering
import ulna.engine.lane_rows  # noqa: F401 - registers the lanes with Numba
from ulna.engine.cache import KernelCache, RoutineCache, cache_folder, compiler_hash
from ulna.engine.numba_private import CACHE, CODE, MEMORY, PASSES, PERMISSION, have, is_tested, turn_off, warn_of_missing
from ulna.engine.shared import share
from ulna.engine.signatures import Array, Group, Kind, Signature

_njit: Any = njit  # its annotations omit some of our flags
_DOCUMENTED = {"fastmath", "error_model", "nogil", "forceinline"}


def is_disabled() -> bool:
    """Whether kernels run as plain Python (``NUMBA_DISABLE_JIT=1``)."""
    return bool(config.DISABLE_JIT)  # pyright: ignore[reportAttributeAccessIssue]


def numba_types(signature: Signature) -> tuple[types.Type, ...]:
    """Convert a signature to Numba's types."""
    return tuple(map(_numba_type, signature))


def compiled(function: Callable, flags: dict[str, Any]) -> Any:
    """A function that Numba compiles at its first call, with our flags.

    Compiled code calls a twin of it, for which no machine code is generated (``pipelines``).
    """
    dispatcher = _dispatcher(function, flags)
    if have(CODE) and not is_disabled():
        _let_callers_use(_dispatcher(function, flags, whole=False, no_cpython_wrapper=True), dispatcher)
    return dispatcher


def compiled_once(function: Callable, flags: dict[str, Any]) -> Any:
    """Like ``compiled``, but compiled once for all callers (``shared``), and stored on disk."""
    if not have(CODE):
        return _dispatcher(function, flags)
    dispatcher = _njit(**flags)(function)
    if not is_disabled():
        within = _dispatcher(function, flags, no_cpython_wrapper=True)
        _keep_on_disk(within, RoutineCache)
        share(within)
        _let_callers_use(within, dispatcher)
    return dispatcher


def compiled_entry(function: Callable, flags: dict[str, Any], may_compile: Callable[[Any], None]) -> Any:
    """Like ``compiled``, but stored on disk; ``may_compile`` raises an error if compiling is not allowed now."""
    dispatcher = _dispatcher(function, flags)
    if is_disabled():
        return dispatcher
    _keep_on_disk(dispatcher, KernelCache)
    if have(PERMISSION):
        _ask_before_compiling(dispatcher, may_compile)
    # Ctrl-C waits while an entry is compiled or loaded from disk.
    dispatcher.compile = _garbage_collection_off()(interrupts_deferred()(dispatcher.compile))
    return dispatcher


def _dispatcher(function: Callable, flags: dict[str, Any], *, whole: bool = True, **more: Any) -> Any:
    """Numba's dispatcher, with our pipeline for functions with machine code, or for inlined ones.

    Without our pipeline it has only the documented flags.
    """
    if not have(CODE):
        return _njit(**{name: flag for name, flag in flags.items() if name in _DOCUMENTED})(function)
    from ulna.engine.pipelines import IRCompiler, WholeCompiler  # noqa: PLC0415 - their base classes are private names of Numba

    return _njit(pipeline_class=WholeCompiler if whole else IRCompiler, **flags, **more)(function)


def _keep_on_disk(dispatcher: Any, kind: type[RoutineCache]) -> None:
    folder = cache_folder() if have(CACHE) else None
    if folder is not None:
        dispatcher._cache = kind(dispatcher.py_func, folder)  # noqa: SLF001 - as njit(cache=True) sets Numba's own


def _let_callers_use(within: Any, dispatcher: Any) -> None:
    """Let compiled code call ``within`` wherever it names a dispatcher.

    Numba would compile a function again for each integer constant among its arguments. LLVM finds such constants itself when it
    inlines the function.
    """
    dispatcher.within = within
    dispatcher.get_call_template = lambda args, kws: within.get_call_template(
        tuple(map(_without_number, args)), {name: _without_number(kind) for name, kind in kws.items()}
    )
    dispatcher.get_overload = within.get_overload


def _without_number(kind: Any) -> Any:
    return types.unliteral(kind) if isinstance(kind, types.IntegerLiteral) else kind


def _ask_before_compiling(dispatcher: Any, may_compile: Callable[[Any], None]) -> None:
    """Check whether this thread may compile, after Numba found no machine code and before it takes its lock."""
    compile_for = dispatcher._compile_for_args  # noqa: SLF001 - the only place before the lock

    def compile_if_permitted(*arguments: Any, **named: Any) -> Any:
        may_compile(dispatcher)
        return compile_for(*arguments, **named)

    dispatcher._compile_for_args = compile_if_permitted  # noqa: SLF001


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Within the block, Ctrl-C waits for the end; a second Ctrl-C ends the program at once.

    Only the main thread gets ``KeyboardInterrupt``, so other threads are unaffected.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    noted = []

    def note(number, frame):
        noted.append((number, frame))
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    try:
        signal.signal(signal.SIGINT, note)  # inside the try block, as another signal may raise just after this call
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if noted:
            handler(*noted[0])


@contextmanager
def _garbage_collection_off() -> Iterator[None]:
    """Within the block, the garbage collector is off: a compilation creates millions of lasting objects."""
    if not gc.isenabled():
        yield
        return
    try:
        gc.disable()
        yield
    finally:
        gc.enable()


def _numba_type(kind: Kind) -> types.Type:
    if isinstance(kind, Group):
        parts = tuple(map(_numba_type, kind.parts))
        return types.Tuple(parts) if kind.of is tuple else cast("types.Type", types.BaseTuple.from_types(parts, kind.of))
    if isinstance(kind, Array):
        element = from_dtype(kind.dtype)
        return types.Array(element, kind.dimensions, "C", readonly=kind.constant)
    return getattr(types, kind.name)


def _check_untested() -> None:
    """Compile a small entry with an untested version of Numba; after a failure, disable our pipeline or our cache."""
    for groups in ((CODE, PASSES, MEMORY), (CACHE,)):
        if is_tested() or is_disabled() or not have(*groups):
            continue
        try:
            import_module("ulna.engine.trial")  # after a failure it is imported again
        except Exception as error:  # noqa: BLE001 - whatever another version raises
            turn_off(groups, f"{type(error).__name__}: {error}")
            compiler_hash.cache_clear()  # it depends on the disabled groups
            cache_folder.cache_clear()


_check_untested()
if not is_disabled():
    warn_of_missing()
