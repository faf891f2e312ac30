"""How a kernel is compiled: the decorators and their flags.

``kernel`` and ``routine`` mark functions that other kernels call; ``entry`` and ``brief_entry`` those that Python calls, whose
machine code is kept on disk (``cache``). They say for which kinds of arguments (``signatures``) they are compiled.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from typing import Any

from numba import njit, typeof
from numba.core import config

from ulna.engine.cache import KernelCache, cache_folder

# 'nnan' and 'ninf' are left out on purpose: NaN in must give NaN out, and then an error, never a plausible number.
# Numba offers each function to C too, which nobody calls here: that way in is not compiled.
_FLAGS: dict[str, Any] = {
    "fastmath": {"contract", "reassoc", "nsz", "arcp"}, "error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True,
}  # fmt: skip
# Range reduction and compensated sums die of 'reassoc': with it, sin(1e5) is wrong by 4e-12 instead of 2e-16.
_EXACT_FLAGS: dict[str, Any] = {**_FLAGS, "fastmath": {"contract", "nsz"}}
# Kernels allocate nothing, so they need not count references: each array handed on would cost two atomic ones. It also keeps
# kernels to their word: one that does allocate is not compiled.
_COUNTS_NOTHING: dict[str, Any] = {"_nrt": False}
_LOW_LATENCY_FLAGS: dict[str, Any] = {**_FLAGS, **_COUNTS_NOTHING, "nogil": False}
Signature = Sequence[Any]  # Numba's types of the arguments
ENTRIES: dict[Any, tuple[Signature, ...]] = {}
"""Every entry, with all the kinds of arguments that it is called with: what there is to compile."""
_lock = threading.Lock()
_closed: set[Any] = set()  # the brief entries that are ready


class NotCompiledError(RuntimeError):
    """An entry was called that is not compiled yet, in a thread that may not compile now (``compiling_if``)."""


class _Permission(threading.local):
    """Whether this thread may compile."""

    may: Callable[[], bool] = staticmethod(lambda: True)


_permission = _Permission()


@contextmanager
def compiling_if(may: Callable[[], bool]) -> Iterator[None]:
    """Within it this thread compiles an entry, or loads it from disk, only while ``may()`` is true.

    Otherwise the call raises ``NotCompiledError`` at once: it does not wait for another thread that compiles either. Numba
    compiles one entry at a time, for up to half a minute.
    """
    before, _permission.may = _permission.may, may
    try:
        yield
    finally:
        _permission.may = before


def _refuse_unless_permitted(entry: Any) -> None:
    if not _permission.may():
        raise NotCompiledError(entry.py_func.__name__)


def kernel(function):
    """Compile a formula: inlined wherever it is called, so that tuples of numbers stay in registers.

    Kernels count no references to arrays. An entry, which allocates and therefore does, must get no array back from one (a
    slice of its own, say): it would let go of what nobody took hold of. ``workspace`` is for that.
    """
    return njit(forceinline=True, **_COUNTS_NOTHING, **_FLAGS)(function)


def routine(function):
    """Compile a longer piece that works on rows: called, which keeps compilation short, unless LLVM thinks inlining worth it.

    Left unsaid, ``forceinline`` would be that of whatever calls it first (Numba's callees inherit it): True from a kernel.
    """
    return njit(forceinline=False, **_COUNTS_NOTHING, **_FLAGS)(function)


def exact_kernel(function):
    """Compile without reassociation, for code that counts on the order of its operations."""
    return njit(forceinline=True, **_COUNTS_NOTHING, **_EXACT_FLAGS)(function)


def workspace(function):
    """Compile what makes arrays for an entry: besides entries the only kind that may return one."""
    return njit(forceinline=False, **_FLAGS)(function)


def entry(*calls: Signature) -> Callable[[Callable], Any]:
    """Compile a function that Python calls, and keep its machine code on disk.

    Args:
        calls: The kinds of its arguments, for each way in which it is called.
    """
    return lambda function: _entry(function, calls, _FLAGS)


def low_latency_entry(call: Signature) -> Callable[[Callable], Any]:
    """Compile a function that Python calls for so little work that the call itself counts; ``ready`` must be asked for it.

    It counts no references, so it allocates nothing, and it does not let go of the interpreter's lock: each of these takes as
    long as a pose. It raises a ``TypeError`` for arguments of other kinds, which the caller need not look at first.
    """

    def compiled(function: Callable) -> Any:
        return _entry(_of_kinds(function, call) if is_plain() else function, (call,), _LOW_LATENCY_FLAGS)

    return compiled


def ready(brief: Any) -> Any:
    """A brief entry, compiled or loaded, and closed to arguments of other kinds."""
    if not is_plain() and brief not in _closed:
        _refuse_unless_permitted(brief)
        with _lock:
            if brief not in _closed:
                brief.compile(tuple(ENTRIES[brief][0]))
                brief.disable_compile()
                _closed.add(brief)
    return brief


def _entry(function: Callable, calls: tuple[Signature, ...], flags: dict[str, Any]) -> Any:
    dispatcher: Any = njit(**flags)(function)
    if not is_plain() and cache_folder() is not None:
        dispatcher._cache = KernelCache(function)  # noqa: SLF001 - as njit(cache=True) sets Numba's own
    if not is_plain():
        _ask_before_compiling(dispatcher)
    ENTRIES[dispatcher] = calls
    return dispatcher


def _ask_before_compiling(dispatcher: Any) -> None:
    """Look whether this thread may compile, where Numba has found no machine code for a call and before it takes its lock."""
    compile_for = dispatcher._compile_for_args  # noqa: SLF001 - the only place before the lock

    def compile_if_permitted(*arguments: Any, **named: Any) -> Any:
        _refuse_unless_permitted(dispatcher)
        return compile_for(*arguments, **named)

    dispatcher._compile_for_args = compile_if_permitted  # noqa: SLF001


def is_plain() -> bool:
    """Whether kernels run as plain Python."""
    return bool(config.DISABLE_JIT)  # pyright: ignore[reportAttributeAccessIssue]


def _of_kinds(function: Callable, kinds: Signature) -> Callable:
    """A function of plain Python that refuses arguments of other kinds, as a compiled one does."""

    @wraps(function)
    def checked(*arguments):
        for argument, kind in zip(arguments, kinds, strict=True):
            if typeof(argument) != kind:
                raise TypeError(f"{typeof(argument)}, but {kind} is expected")
        return function(*arguments)

    return checked
