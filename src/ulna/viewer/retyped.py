"""Numbers that a form shows rounded, and what was typed over them. Used by ``obstacle_form`` and ``hand_pose``."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_DIGITS = 4  # decimals: tenths of millimetres


def retyped(exact: NDArray[Any], typed: tuple[float, ...]) -> NDArray[Any]:
    """The typed numbers that differ from what the form showed; the exact ones for the others, which the form rounds."""
    return np.where(np.equal(typed, rounded(exact)), exact, typed)


def rounded(values: NDArray[Any]) -> tuple[float, ...]:
    """Numbers as the form shows them."""
    return tuple(float(value) + 0.0 for value in values.round(_DIGITS))
