"""Marks functions for the compiler, with its flags.

``kernel``, ``exact_kernel``, ``routine``, ``shared_routine`` and ``workspace`` mark functions that other kernels call. ``entry``
and ``low_latency_entry`` mark functions that Python calls. Those declare the types of their arguments (``signatures``), and their
machine code is stored on disk (``cache``). In a wheel an entry is machine code that was compiled ahead (``ahead``).
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, NamedTuple, ParamSpec, TypeVar

from ulna.engine.ahead import ahead_entry
from ulna.engine.signatures import Signature, checked
from ulna.engine.sources import text_of

try:
    from ulna.engine import compiler
except ModuleNotFoundError as error:  # machine code compiled ahead needs no compiler
    if error.name not in {"numba", "llvmlite"}:
        raise
    compiler = None

# 'nnan' and 'ninf' are omitted on purpose: NaN in must give NaN out, and then an error, never a plausible number. The wrapper for
# calls from C is omitted, since nothing calls it.
_FLAGS: dict[str, Any] = {
    "fastmath": {"contract", "reassoc", "nsz", "arcp"}, "error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True,
}  # fmt: skip
# Range reduction and compensated sums fail with 'reassoc': the error of sin(1e5) would be 4e-12 instead of 2e-16.
_EXACT_FLAGS: dict[str, Any] = {**_FLAGS, "fastmath": {"contract", "nsz"}}
# Kernels allocate nothing, so they need no reference counts, which would cost two atomic operations for each array argument. An
# allocating kernel is not compiled with this flag.
_NO_REFERENCE_COUNTS: dict[str, Any] = {"_nrt": False}
_LOW_LATENCY_FLAGS: dict[str, Any] = {**_FLAGS, **_NO_REFERENCE_COUNTS, "nogil": False}


P = ParamSpec("P")
ResultT = TypeVar("ResultT")


class Calls(NamedTuple):
    """The signatures of an entry; one of low latency is compiled for its only signature."""

    name: str
    """Its package, module and function, such as ``ulna.kinematics.entries.forward.forward_one``."""
    signatures: tuple[Signature, ...]
    low_latency: bool = False


ENTRIES: dict[Any, Calls] = {}
"""Every entry imported so far."""
_lock = threading.Lock()
_closed: set[Any] = set()  # compiled entries of low latency, which accept no other signature


class NotCompiledError(RuntimeError):
    """An entry is not compiled yet, and its thread may not compile now (``compiling_if``)."""


class _Permission(threading.local):
    """Whether this thread may compile."""

    may: Callable[[], bool] = staticmethod(lambda: True)


_permission = _Permission()


@contextmanager
def compiling_if(may: Callable[[], bool]) -> Iterator[None]:
    """Within the block, this thread compiles an entry, or loads it from disk, only while ``may()`` is true.

    Otherwise the call raises ``NotCompiledError`` at once, and does not wait for another compiling thread either. Numba compiles
    one entry at a time, for up to half a minute.
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
    """Mark a formula: inlined wherever it is called, so that tuples of numbers stay in registers.

    Kernels count no references to arrays. So an entry, which does count them, must not get an array from a kernel (a slice, for
    example): it would decref an array that it does not own. Use ``workspace`` for that.
    """
    return _compiled(function, forceinline=True, **_NO_REFERENCE_COUNTS, **_FLAGS)


def routine(function):
    """Mark a longer piece that works on rows: called, which keeps compilation short, unless LLVM inlines it.

    Without ``forceinline=False`` it would take the setting of its first caller (Numba's callees inherit it): True from a kernel.
    """
    return _compiled(function, forceinline=False, **_NO_REFERENCE_COUNTS, **_FLAGS)


def shared_routine(function):
    """Mark a long routine that is compiled once and called by all entries; short ones cost too much per call."""
    return _compiled(function, once=True, forceinline=False, **_NO_REFERENCE_COUNTS, **_FLAGS)


def exact_kernel(function):
    """Mark a formula that depends on the order of its operations: compiled without reassociation."""
    return _compiled(function, forceinline=True, **_NO_REFERENCE_COUNTS, **_EXACT_FLAGS)


def workspace(function):
    """Mark a function that makes arrays for an entry: besides entries the only kind that may return an array."""
    return _compiled(function, forceinline=False, **_FLAGS)


def entry(*signatures: Signature) -> Callable[[Callable[P, ResultT]], Callable[P, ResultT]]:
    """Mark a function that Python calls; its machine code is stored on disk.

    Args:
        signatures: The types of its arguments, for each way of calling it.
    """
    return lambda function: _entry(function, signatures, _FLAGS)


def low_latency_entry(signature: Signature) -> Callable[[Callable[P, ResultT]], Callable[P, ResultT]]:
    """Mark a function that Python calls for less than a microsecond of work, where the call itself counts.

    It counts no references, so it allocates nothing, and it keeps the interpreter's lock: each of these costs as much as a pose.
    ``entries.ready`` compiles it for its only signature, so arguments of other types raise a ``TypeError``.
    """
    return lambda function: _entry(function, (signature,), _LOW_LATENCY_FLAGS, low_latency=True)


def _compile_only(marked: Any, signature: Signature) -> None:
    """Compile an entry of low latency for its signature, or load it from disk, and disable further compilation."""
    if marked in _closed:
        return
    _refuse_unless_permitted(marked)
    with _lock:
        if marked not in _closed:
            marked.compile(compiler.numba_types(signature))  # pyright: ignore[reportOptionalMemberAccess] - it made ``marked``
            marked.disable_compile()
            _closed.add(marked)


def is_plain() -> bool:
    """Whether kernels run as plain Python: ``NUMBA_DISABLE_JIT=1``, or there is no compiler."""
    return compiler is None or compiler.is_disabled()


def _compiled(function: Callable, *, once: bool = False, **flags: Any) -> Any:
    _remember(function)
    if compiler is None:
        return function
    return compiler.compiled_once(function, flags) if once else compiler.compiled(function, flags)


def _remember(function: Callable) -> None:
    """Read the function's file now, so that the cache's key belongs to the loaded text."""
    with suppress(OSError):  # a kernel typed into an interpreter or a notebook has no file, and no entry is stored for it
        text_of(function.__code__.co_filename)


def _entry(function: Callable, signatures: tuple[Signature, ...], flags: dict[str, Any], *, low_latency: bool = False) -> Any:
    _remember(function)
    marked: Any = ahead_entry(function.__module__, function.__name__)
    if marked is None:
        marked = function if compiler is None else compiler.compiled_entry(function, flags, _refuse_unless_permitted)
        if low_latency:
            if marked is function:  # it runs as plain Python
                marked = checked(function, signatures[0])
            else:
                marked.compile_now = partial(_compile_only, marked, signatures[0])
    ENTRIES[marked] = Calls(f"{function.__module__}.{function.__name__}", signatures, low_latency)
    return marked
