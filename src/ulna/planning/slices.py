"""Divides a search into slices, between which it may end: by Ctrl-C, a time limit, another search. Used by ``search``."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from ulna.errors import UlnaError
from ulna.kernels.planning import planning_layout as layout

_FIRST_SLICE, _LONGEST_SLICE = 64, 0.02  # checked edges; seconds
_here = threading.local()


class StoppedError(UlnaError):
    """A search that was ended because another one failed, or by Ctrl-C in another thread."""


@contextmanager
def stopping(event: threading.Event) -> Iterator[None]:
    """Within the block, searches of this thread end when an event is set, by a ``StoppedError``."""
    _here.stopped = event
    try:
        yield
    finally:
        _here.stopped = None


class Slices:
    """Divides a run into slices of checked edges, so that Ctrl-C and a time limit act soon.

    What is computed does not depend on the slices.
    """

    def __init__(self, max_checks: int, time_limit: float | None) -> None:
        self._most, self._slice = max_checks, _FIRST_SLICE
        self._began = self._last = time.perf_counter()
        self._end = np.inf if time_limit is None else self._began + time_limit

    def another(self, state: NDArray[np.int64]) -> bool:
        """Whether there is another slice; if so, state[UNTIL] is set."""
        now, stopped = time.perf_counter(), getattr(_here, "stopped", None)
        if stopped is not None and stopped.is_set():
            raise StoppedError
        if now >= self._end or state[layout.CHECKS] >= self._most:
            return False
        if state[layout.UNTIL] > 0:
            too_long = now - self._last > _LONGEST_SLICE
            self._slice = max(1, self._slice // 2) if too_long else 2 * self._slice
        self._last = now
        state[layout.UNTIL] = min(self._most, int(state[layout.CHECKS]) + self._slice)
        return True
