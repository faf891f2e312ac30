"""Limits the time of a search, counted after its first slice, which may compile the kernels."""

import math
import time

import numpy as np

from ulna.description.arrays import as_number
from ulna.errors import InputError


class TimeLimit:
    """The time limit of one search, or of several together [s]; None for no limit.

    The time counts from the end of the first slice, which may compile the kernels.

    Attributes:
        seconds: The limit; infinite for no limit.
    """

    def __init__(self, seconds: float | None) -> None:
        self.seconds = np.inf if seconds is None else seconds
        self._end = np.inf

    def begin(self, now: float) -> None:
        """Start the clock, unless it is running."""
        self._end = min(self._end, now + self.seconds)

    def is_over(self) -> bool:
        """Whether the time is over."""
        return time.perf_counter() >= self._end

    def refuse_longer(self, advice: str) -> None:
        """Raise an error if the time is over.

        Raises:
            InputError: It is over.
        """
        if self.is_over():
            raise InputError("time_limit", f"{self.seconds:g} s are over; {advice}")


def as_time_limit(time_limit: object) -> float | None:
    """The time limit of a search [s]; None or infinity for no limit."""
    expected = "a time [s] above 0, or None for no limit,"
    return None if time_limit is None else as_number("time_limit", time_limit, 0.0, expected, above=True, most=math.inf)
