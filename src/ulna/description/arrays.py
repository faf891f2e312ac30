"""Checks arrays, numbers, counts and switches that a caller passes."""

import sys
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError

_FLOAT64 = np.dtype(np.float64)
_LARGEST = sys.float_info.max
MAX_COUNTED = 2**31 - 1  # the kernels' limit


def as_floats(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Convert values to a C-contiguous, writable float64 array; such an array is returned unchanged.

    A read-only array is copied: Numba would compile the kernels again for its type.
    """
    if type(values) is np.ndarray and values.dtype is _FLOAT64:
        return values if values.flags.carray else values.copy()
    if _has_mask(values):
        raise InputError(name, "a masked array, whose mask would be lost")
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "biuf":
            raise InputError(name, f"not an array of numbers (it holds {_what(array)})")
        array = np.asarray(array, dtype=np.float64, order="C")
        return array if array.flags.carray else array.copy()
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(name, f"not an array of numbers ({error})") from None


def as_cells(name: str, values: ArrayLike, unseen: int) -> NDArray:
    """Convert values to an array of any type; masked entries become ``unseen``.

    Raises:
        InputError: They form no array.
    """
    try:
        return np.asarray(np.ma.filled(values, unseen))
    except ValueError as error:
        raise InputError(name, f"not an array ({error})") from None


def as_number(
    name: str,
    value: object,
    least: float = -_LARGEST,
    expected: str = "a finite number",
    *,
    above: bool = False,
    most: float = _LARGEST,
) -> float:
    """A number from ``least`` to ``most``, or above ``least``; infinite only if ``most`` is."""
    if type(value) is float and least < value <= most:
        return value  # fast path of the most frequent case: a fourth of the time
    try:
        number = float(value) if isinstance(value, (float, int, Real)) and not isinstance(value, bool) else np.nan
    except OverflowError:  # an integer above every float
        number = np.nan
    if not (least < number if above else least <= number) or not number <= most:
        raise InputError(name, f"{_shortened(value)}; {expected} is expected")
    return number


def positive(name: str, value: object, expected: str = "a number above 0") -> float:
    """A finite number above 0."""
    return as_number(name, value, 0.0, expected, above=True)


def as_count(name: str, value: object, least: int = 0, most: int = MAX_COUNTED) -> int:
    """An integer from ``least`` to ``most``."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InputError(name, f"{_shortened(value)}; a whole number from {least} to {most} is expected")
    return int(value)


def as_switch(name: str, value: object) -> bool:
    """True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(name, f"{_shortened(value)}; True or False is expected")
    return bool(value)


def _shortened(value: object) -> str:
    """Format a value like ``repr``, without the digits of an integer beyond the range of floats."""
    if isinstance(value, int) and abs(value) > _LARGEST:
        return "a whole number of more than 308 digits"
    return repr(value)


def _what(array: NDArray) -> str:
    return {"c": "complex numbers", "U": "text", "S": "text", "O": "objects"}.get(array.dtype.kind, str(array.dtype))


def _has_mask(values: object, levels: int = 64) -> bool:
    """Whether values are a masked array, or a list that contains one, within the depth of arrays."""
    if isinstance(values, list | tuple):
        return levels > 0 and any(_has_mask(value, levels - 1) for value in values if not isinstance(value, float | int))
    return isinstance(values, np.ma.MaskedArray)
