"""Compiles a small entry on import: it calls a shared routine, which calls a kernel.

``compiler`` imports it for an untested version of Numba, to check whether the engine can compile with it.
"""

import numpy as np

from ulna.engine import compiler
from ulna.engine.lanes import empty_rows, load, store

_FLAGS = {"no_cfunc_wrapper": True, "_nrt": False, "fastmath": {"contract"}}


def square(x):
    """The square of a number, or of eight numbers."""
    return x * x


square = compiler.compiled(square, {"forceinline": True, **_FLAGS})


def squares(rows):
    """Square the only row."""
    store(rows, 0, square(load(rows, 0)))


squares = compiler.compiled_once(squares, {"forceinline": False, **_FLAGS})


def sum_of_squares(x):
    """The sum of the squares of eight numbers."""
    rows = empty_rows(1)
    for lane in range(8):
        rows[0, lane] = x[lane]
    squares(rows)
    return rows[0].sum()


sum_of_squares = compiler.compiled_entry(sum_of_squares, {"no_cfunc_wrapper": True}, lambda _: None)
if sum_of_squares(np.arange(8.0)) != 140.0:
    raise ArithmeticError("a small entry gives a wrong sum")
