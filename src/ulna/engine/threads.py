"""Large batches in parts, one after the other or side by side in threads.

The parts begin at multiples of the number of lanes, so that no block is cut, and the kernels give each row the same result
whatever its block: the answer is bit for bit that of one call.
"""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache

from ulna.engine.width import WIDTH

LEAST_ROWS = 1024  # of a part, where a row takes less than a microsecond
LEAST_POSES = 16 * LEAST_ROWS  # of a part, where a row takes some twenty nanoseconds: a thread takes tens of microseconds to ask


def in_parts(run: Callable[[slice], bool], n: int, least: int = LEAST_ROWS, threads: int | None = None) -> bool:
    """Run a kernel over rows 0 to n in parts, and say whether it said yes to all. However this ends, no part runs on behind it.

    Args:
        run: Calls the kernel for the rows of a slice; the kernel lets go of the interpreter's lock (``nogil``).
        n: How many rows there are.
        least: How few rows are worth a thread.
        threads: How many to use; as many as there are processors unless given.

    Example:
        >>> import numpy as np
        >>> x, y = np.arange(5000.0), np.empty(5000)
        >>> in_parts(lambda rows: np.sqrt(x[rows], out=y[rows]) is not None, 5000), float(y[4900])
        (True, 70.0)
    """
    threads = n_processors() if threads is None else threads
    n_parts = min(4 * threads, n // least)
    if n_parts < 2 or threads < 2:
        return run(slice(0, n))
    step = -(-n // n_parts // WIDTH) * WIDTH
    pool = _pool(os.getpid(), threads)
    parts: list[Future[bool]] = []
    try:
        parts.extend(pool.submit(run, slice(start, min(start + step, n))) for start in range(0, n, step))
        return all(part.result() for part in parts)
    finally:  # the caller's array is the caller's again
        wait([part for part in parts if not part.cancel()])


@cache
def n_processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(process: int, threads: int) -> ThreadPoolExecutor:  # noqa: ARG001 - a fork has no threads but the one that made it: it gets its own
    return ThreadPoolExecutor(threads, thread_name_prefix="ulna")
