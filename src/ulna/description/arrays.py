"""Checks arrays of numbers that a caller passes."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError

_FLOAT64 = np.dtype(np.float64)


def as_floats(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """The values as a C-contiguous, writable float64 array, itself where it is one already.

    A read-only array is copied: Numba would compile the kernels again for its type.

    Raises:
        InputError: They are not numbers, or complex ones, whose imaginary part would be lost.
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


def _what(array: NDArray) -> str:
    return {"c": "complex numbers", "U": "text", "S": "text", "O": "objects"}.get(array.dtype.kind, str(array.dtype))


def _has_mask(values: object, levels: int = 64) -> bool:
    """Whether they are a masked array, or a list that holds one, within the levels that an array may have."""
    if isinstance(values, list | tuple):
        return levels > 0 and any(_has_mask(value, levels - 1) for value in values if not isinstance(value, float | int))
    return isinstance(values, np.ma.MaskedArray)
