"""The longest time of a search, which counts from when it computes: the kernels may be compiled first."""

import math
import time

import numpy as np

from ulna.description.arrays import as_number
from ulna.errors import InputError


class TimeLimit:
    """The longest time of one search, or of several together [s]; None for no limit.

    It is counted from the end of the first slice, in which the kernels may be compiled.

    Attributes:
        seconds: That time; infinite for no limit.
    """

    def __init__(self, seconds: float | None) -> None:
        self.seconds = np.inf if seconds is None else seconds
        self._end = np.inf

    def begin(self, now: float) -> None:
        """Count from now on, unless it has begun."""
        self._end = min(self._end, now + self.seconds)

    def is_over(self) -> bool:
        """Whether the time is over."""
        return time.perf_counter() >= self._end

    def refuse_longer(self, advice: str) -> None:
        """Refuse to go on if the time is over.

        Raises:
            InputError: It is over.
        """
        if self.is_over():
            raise InputError("time_limit", f"{self.seconds:g} s are over; {advice}")


def as_time_limit(time_limit: object) -> float | None:
    """The longest time of a search [s]; None or infinity for no limit."""
    expected = "a time [s] above 0, or None for no limit,"
    return None if time_limit is None else as_number("time_limit", time_limit, 0.0, expected, above=True, most=math.inf)
