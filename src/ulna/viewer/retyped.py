"""Rounds numbers for a form, and finds those that were typed over."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_DIGITS = 4  # decimals: tenths of millimetres


def retyped(exact: NDArray[Any], typed: tuple[float, ...]) -> NDArray[Any]:
    """The typed numbers where they differ from the rounded ones that the form showed; the exact numbers elsewhere."""
    return np.where(np.equal(typed, rounded(exact)), exact, typed)


def rounded(values: NDArray[Any]) -> tuple[float, ...]:
    """Numbers as the form shows them."""
    return tuple(float(value) + 0.0 for value in values.round(_DIGITS))
