"""Defines the operations on a number or on eight numbers at once, in which every kernel is written.

Each is a plain function of NumPy, which runs unchanged without the compiler (``NUMBA_DISABLE_JIT=1``). Compiled, it is an
operation on a float64, or on the vector ``f64x8`` (``lane_types``, ``lane_lowering``). Kernels call these instead of ``math.*``,
which refuses arrays. Besides these a number has ``+ - * /``, ``abs`` and comparisons, and a mask has ``&``, ``|`` and ``^``.
"""

import numpy as np

WIDTH = 8
"""The number of problems in a number of lanes."""


def sqrt(x):
    """Square root of a number."""
    return np.sqrt(x)


def rint(x):
    """Nearest integer, ties to even."""
    return np.rint(x)


def where(mask, x, y):
    """x where the mask is true, y elsewhere: a choice without branching."""
    return np.where(mask, x, y)[()]


def logical_not(mask):
    """The negated mask (``~True`` would be -2)."""
    return np.logical_not(mask)


def any_lane(mask):
    """Whether any lane of the mask is true: a plain bool, fit for ``if``."""
    return bool(np.any(mask))


def lane_bits(mask):
    """The mask as an integer: bit k is lane k. For a search that tests eight children at once."""
    return int(np.sum(np.asarray(mask, dtype=np.int64) << np.arange(np.size(mask))))


def lowest_bit(bits):
    """The index of the lowest set bit of an integer above zero."""
    return (bits & -bits).bit_length() - 1


def splat(x, like):
    """Convert the plain number x to the type of ``like``."""
    return np.full(np.shape(like), x, dtype=np.float64)[()]


def empty_rows(n):
    """n uninitialized rows of lanes, shape (n, 8), n >= 0. Compiled, each row is aligned to its 64 bytes."""
    return np.empty((n, WIDTH))


def zero_rows(n):
    """n rows of lanes like those of ``empty_rows``, filled with zeros."""
    return np.zeros((n, WIDTH))


def load(rows, i):
    """Number i of rows."""
    return rows[i].copy()


def store(rows, i, x):
    """Write number x to place i of rows."""
    rows[i] = x


def lane_count(x):
    """The number of problems in a number: 1 for a plain one."""
    return np.size(x)


def lane_of(x, lane):
    """A number's value in one lane: a plain number."""
    return np.ravel(x)[lane]


def with_lane(x, lane, y):
    """A number with the plain number y in one lane."""
    values = np.array(x, dtype=np.float64)
    values.ravel()[lane] = y
    return values[()]


def load_columns(array, i, k):
    """Load eight columns of an array from k on as numbers, whose lanes are eight rows from i on.

    A row past the last one is the last one. The array has two or more axes and at least one row; the axes after the first form a
    row. Columns past the end of a row belong to the next row. No column past the end of the last row may be requested.
    """
    flat, n = array.reshape(-1), array.shape[0]
    starts = [min(i + lane, n - 1) * (array.size // n) + k for lane in range(WIDTH)]
    return tuple(np.array([flat[start : start + WIDTH] for start in starts]).T.copy())


def store_columns(array, i, k, numbers):
    """Write numbers to eight columns of an array from k on, their lanes to eight existing rows from i on."""
    flat, columns = array.reshape(-1), array.size // array.shape[0]
    for lane, run in enumerate(np.array(numbers).T):
        start = (i + lane) * columns + k
        flat[start : start + WIDTH] = run
