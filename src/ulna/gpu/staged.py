"""Makes drivers that copy rows in and out through shared memory.

Adjacent threads have adjacent problems. If each thread read its own row, number by number, a warp would touch one line of memory
per thread and number. So the threads of a block copy its rows together into shared memory, in consecutive order. Each computes
from its row to a row of results there, and all write these together.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from ulna.engine.decorators import kernel
from ulna.errors import DeviceError
from ulna.gpu.device import THREADS, cuda

_ROOM = 48 << 10  # bytes of shared memory that a block has by default
MATRIX = 16  # numbers of a pose
_BYTES = 8  # of the largest number


def threads_for(taken: int, given: int, each: int = 1) -> int:
    """The number of threads of a block whose input and output rows fit into shared memory."""
    threads = THREADS
    while threads > each and _bytes_of(threads, taken, given, each) > _ROOM:
        threads //= 2
    return threads


def _bytes_of(n_threads: int, taken: int, given: int, each: int) -> float:
    """The shared memory of a block's rows [bytes]."""
    return _BYTES * n_threads * (_padded(taken) / each + _padded(given))


@cache
def over_rows(
    formula: Callable,
    taken: int | None,
    given: int,
    *,
    beside: int = 0,
    pieces: int = 1,
    each: int = 1,
    scratch: int = 1,
    dtype: Any = np.float64,
) -> Any:
    """The driver ``driver(tables, rows, out, marks)`` of a formula over one row.

    It sets ``marks[0][0]`` if a formula returns true: its row is invalid. ``driver.threads`` is the number of threads of a block.

    Args:
        formula: A kernel ``formula(tables, row, place, scratch, given, marks)``. ``place``: the index of the problem, the index
            of the piece of its results, and the index of its thread.
        taken: Numbers of a row, which are copied from rows, shape (n, taken); None: 4x4 matrices, shape (n, 4, 4).
        given: Numbers of a piece of the results, which are copied to out, shape (each n, pieces * given).
        beside: The number of arrays like rows in ``tables[-1]``, a tuple; their rows follow the formula's own row.
        pieces: Calls of the formula per row: results too large for shared memory are written in pieces.
        each: The number of threads with the same row: the problems of a row are adjacent.
        scratch: The size of a thread's own scratch, kept from piece to piece.
        dtype: The type of the results.

    Raises:
        DeviceError: The rows of one problem do not fit into the shared memory of a block.
    """
    width = taken or MATRIX
    threads, more = threads_for(width * (beside + 1), given, each), copy_beside_in if beside else copy_nothing_in
    needed = _bytes_of(threads, width * (beside + 1), given, each)
    if needed > _ROOM:
        numbers = f"{width * (beside + 1)} numbers and {given} results"
        raise DeviceError(
            f"{numbers} of a problem need {needed / 1e3:.0f} kB of shared memory, of {_ROOM / 1e3:.0f}; use the CPU"
        )
    n_rows, copy, length = threads // each, copy_in if taken else copy_matrices_in, (taken or 4) * (beside + 1)
    of_taken, of_given = (n_rows, _padded(length)) if taken else (n_rows, 4, 4), (threads, _padded(given))

    def driver(tables, rows, out, marks):
        room = cuda.shared.array(of_taken, np.float64)
        results = cuda.shared.array(of_given, dtype)
        own = cuda.local.array(scratch, np.float64)
        thread = cuda.threadIdx.x
        mine = thread // each
        for first in range(cuda.blockIdx.x * n_rows, rows.shape[0], cuda.gridDim.x * n_rows):
            n = min(n_rows, rows.shape[0] - first)
            copy(rows, first, n, (thread, threads, width), room)
            more(tables, first, n, (thread, threads, width), room)
            cuda.syncthreads()
            for k in range(pieces):
                if mine < n:
                    place = first * each + thread, k, cuda.grid(1)
                    if formula(tables, room[mine][:length], place, own, results[thread][:given], marks):
                        marks[0][0] = 1
                cuda.syncthreads()
                copy_out(results, (first * each, n * each), k, (thread, threads, given), out)
                cuda.syncthreads()

    driver.__name__ = driver.__qualname__ = formula.__name__
    driver.threads = threads  # pyright: ignore[reportFunctionMemberAccess]
    return driver


@kernel
def copy_in(rows, first, n, thread, room):
    """Copy n rows, from index ``first`` on, to shared memory.

    thread: the index of this thread, the number of threads, and the length of a row.
    """
    row, column = thread[0] // thread[2], thread[0] % thread[2]
    while row < n:
        room[row, column] = rows[first + row, column]
        row, column = following(row, column, thread)


@kernel
def copy_beside_in(tables, first, n, thread, room):
    """Copy the rows of the arrays in ``tables[-1]`` next to the rows in shared memory."""
    for k in range(len(tables[-1])):
        copy_in(tables[-1][k], first, n, thread, room[:, (k + 1) * thread[2] :])


@kernel
def copy_nothing_in(_tables, _first, _n, _thread, _room):
    """Copy nothing: there are no further arrays."""


@kernel
def copy_matrices_in(rows, first, n, thread, room):
    """Copy n 4x4 matrices, from index ``first`` on, to shared memory."""
    for j in range(thread[0], MATRIX * n, thread[1]):
        room[j // MATRIX, j // 4 % 4, j % 4] = rows[first + j // MATRIX, j // 4 % 4, j % 4]


@kernel
def copy_out(results, part, k, thread, out):
    """Copy piece k of rows in shared memory to the rows of a part: its first row, and their number."""
    row, column = thread[0] // thread[2], thread[0] % thread[2]
    while row < part[1]:
        out[part[0] + row, k * thread[2] + column] = results[row, column]
        row, column = following(row, column, thread)


@kernel
def following(row, column, thread):
    """The row and column that many numbers ahead as there are threads."""
    row, column = row + thread[1] // thread[2], column + thread[1] % thread[2]
    if column >= thread[2]:
        return row + 1, column - thread[2]
    return row, column


def _padded(width: int) -> int:
    """An odd number of columns, so that adjacent threads use different memory banks."""
    return width | 1
