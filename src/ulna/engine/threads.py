"""Runs large batches in parts in several threads, and holds the setting of their number.

The parts begin at multiples of the number of lanes, so no block of lanes is split. The result of a row does not depend on its
block: it is bit for bit that of one call.

A part is run in slices of some hundredths of a second: Python notices Ctrl-C between two calls of an entry, not within one. Work
within these threads is serial: they run in copies of the caller's context, in which the setting is 1.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar, copy_context
from functools import cache
from operator import index
from time import perf_counter
from typing import TYPE_CHECKING

from ulna.engine.lanes import WIDTH
from ulna.engine.processors import n_processors
from ulna.errors import InputError, cited

if TYPE_CHECKING:
    from concurrent.futures import Future, ThreadPoolExecutor

MIN_ROWS = 1024  # rows of a part, if a row takes about a microsecond
MIN_POSES = 16 * MIN_ROWS  # rows of a part, if a row takes about 20 ns; waking a thread takes tens of microseconds
VARIABLE = "ULNA_THREADS"
_MAX_THREADS = 2**31 - 1
_SECONDS = 0.02  # duration of a slice
_MAX_GROWTH = 16.0  # of a slice relative to the one before
_chosen: ContextVar[int | None] = ContextVar("ulna.threads", default=None)


def threads(n: int | None) -> AbstractContextManager[None]:
    """Set the maximum number of threads of a batch: from now on, or in ``with ulna.threads(n):`` until the block ends.

    Results are the same bit for bit. The setting belongs to a context (``contextvars``): a thread that the program starts has the
    default until it is set there.

    Args:
        n: The number of threads, including the calling one, at least 1. None is the default: ``ULNA_THREADS``, or the number of
            processors that the process may use.

    Raises:
        InputError: n is no such number.

    Example:
        >>> import numpy as np, ulna
        >>> panda = ulna.load("panda")
        >>> with ulna.threads(1):
        ...     T = panda.forward_kinematics(np.zeros((100, 7)))
    """
    return _Setting(None if n is None else _as_threads(n))


class _Setting(AbstractContextManager[None]):
    """A setting made by ``threads``; the end of a ``with`` block restores the one before."""

    def __init__(self, n: int | None) -> None:
        self._n, self._before = n, _chosen.get()
        _chosen.set(n)

    def __enter__(self) -> None:
        _chosen.set(self._n)

    def __exit__(self, *_: object) -> None:
        _chosen.set(self._before)


def _as_threads(n: int) -> int:
    try:
        number = 0 if isinstance(n, bool) else index(n)
    except TypeError:
        number = 0
    if not 1 <= number <= _MAX_THREADS:
        raise InputError("threads", f"{cited(n)}; a whole number from 1 to {_MAX_THREADS} is expected, or None for the default")
    return number


def n_threads() -> int:
    """The maximum number of threads of a batch in this context: the setting of ``threads``, or else the default."""
    return _chosen.get() or default_threads()


def in_parts(run: Callable[[slice], bool], n: int, least: int = MIN_ROWS) -> bool:
    """Call an entry for rows 0 to n in parts; returns whether all returned True. No part runs afterwards.

    Args:
        run: Calls the entry for the rows of a slice; the entry releases the interpreter's lock (``nogil``).
        n: The number of rows.
        least: The minimum number of rows per thread.

    Example:
        >>> import numpy as np
        >>> x, y = np.arange(5000.0), np.empty(5000)
        >>> in_parts(lambda rows: np.sqrt(x[rows], out=y[rows]) is not None, 5000), float(y[4900])
        (True, 70.0)
    """
    if n <= 1:
        return run(slice(0, n))
    n_workers = n_threads()  # before any row, so that a refused setting is refused for every batch
    if n <= least:
        return run(slice(0, n))
    n_parts, ended = min(4 * n_workers, n // least), []
    if n_parts < 2 or n_workers < 2:
        return in_slices(run, slice(0, n), least)
    step = -(-n // n_parts // WIDTH) * WIDTH
    parts = deque(slice(start, min(start + step, n)) for start in range(0, n, step))
    return _in_threads(lambda part: in_slices(run, part, least, ended), parts, n_workers, lambda: ended.append(True))


def in_slices(run: Callable[[slice], bool], part: slice, least: int, ended: Sequence[bool] = ()) -> bool:
    """Run a part slice by slice until ``ended`` has an entry: first ``least`` rows, then slices of ``_SECONDS``."""
    rows = -(-least // WIDTH) * WIDTH
    if part.stop - part.start <= rows:
        return run(part)
    start = part.start
    while start < part.stop and not ended:
        stop, began = min(start + rows, part.stop), perf_counter()
        if not run(slice(start, stop)):
            return False
        share = _SECONDS / max(perf_counter() - began, 1e-9)
        rows = max(1, int(min(share, _MAX_GROWTH) * rows) // WIDTH) * WIDTH
        start = stop
    return True


def _in_threads(
    run: Callable[[slice], bool], waiting: deque[slice], n_workers: int, stop: Callable[[], object] | None = None
) -> bool:
    """Run parts in threads including this one; on a failure, call ``stop`` before waiting for the others."""
    from concurrent.futures import wait  # noqa: PLC0415 - keeps `import ulna` fast

    helpers: list[Future[bool]] = []
    try:
        with threads(1):
            n_helpers = min(n_workers, _pool_size()) - 1
            helpers.extend(_pool().submit(copy_context().run, _run_waiting, run, waiting) for _ in range(n_helpers))
            good = _run_waiting(run, waiting)
        return all([good, *(helper.result() for helper in helpers if not helper.cancel())])
    except BaseException:
        if stop is not None:
            stop()
        raise
    finally:  # afterwards no thread writes to the caller's array
        waiting.clear()
        wait([helper for helper in helpers if not helper.cancel()])


def in_rows(run: Callable[[int], bool], n: int, stop: Callable[[], object] | None = None) -> bool:
    """Call a function for each row from 0 to n, if each takes long; otherwise like ``in_parts``.

    ``stop`` is called when a row fails, or at Ctrl-C: it ends the rows in other threads, which are waited for.
    """
    n_workers = n_threads() if n > 1 else 1
    if n_workers < 2:
        return all(map(run, range(n)))
    return _in_threads(lambda part: run(part.start), deque(slice(i, i + 1) for i in range(n)), n_workers, stop)


def _run_waiting(run: Callable[[slice], bool], waiting: deque[slice]) -> bool:
    """Run the parts that no other thread has taken yet; after a failure the remaining parts are dropped."""
    good = False
    try:
        while (part := _next_of(waiting)) is not None:
            if not run(part):
                return False
        good = True
    finally:
        if not good:
            waiting.clear()
    return good


def _next_of(waiting: deque[slice]) -> slice | None:
    try:
        return waiting.popleft()
    except IndexError:
        return None


@cache
def default_threads() -> int:
    """The default number of threads of a batch: ``ULNA_THREADS``, or the number of usable processors.

    It is determined once per process, and again after a fork.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return n_processors()
    if not text.isdecimal() or not 1 <= int(text) <= _MAX_THREADS:
        raise InputError(VARIABLE, f"{text!r}; the environment variable must be a whole number of threads, at least 1")
    return int(text)


@cache
def _pool_size() -> int:
    """The maximum useful number of threads: one per processor of the machine."""
    return os.cpu_count() or 1


@cache
def _pool() -> ThreadPoolExecutor:
    """The only thread pool. It starts no more threads than are needed at once, whatever number the calls request."""
    from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415 - keeps `import ulna` fast

    return ThreadPoolExecutor(_pool_size(), thread_name_prefix="ulna")


def _forget() -> None:
    """Clear what a fork must determine again: affinity, environment, threads."""
    default_threads.cache_clear()
    _pool.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
