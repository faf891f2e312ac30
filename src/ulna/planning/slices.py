"""Divides a search into slices, between which it may end: by Ctrl-C, a time limit, another search."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from ulna.errors import UlnaError
from ulna.ik.time_limit import TimeLimit
from ulna.planning.search_records import SearchState, ShorteningState

MAX_CHECKS = 2**62 - 1
_FIRST_SLICE, _LONGEST_SLICE = 64, 0.02  # checked edges; seconds
_MAX_GROWTH = 16.0  # from one slice to the next
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


class Pace:
    """How many checked edges a slice has: as many as take about a hundredth of a second, once it is known how long they take.

    Attributes:
        checks: That number.
    """

    def __init__(self) -> None:
        self.checks = _FIRST_SLICE

    def adapt(self, seconds: float, checks: int) -> None:
        """Take note of how long so many checked edges took."""
        wanted = 0.5 * _LONGEST_SLICE * max(1, checks) / max(seconds, 1e-9)
        self.checks = max(1, int(min(max(wanted, self.checks / 2), _MAX_GROWTH * self.checks)))


class Slices:
    """Divides a run into slices of checked edges, so that Ctrl-C and a time limit act soon.

    What is computed does not depend on the slices.
    """

    def __init__(self, max_checks: int, limit: TimeLimit, pace: Pace) -> None:
        self._most, self._limit, self._pace, self._before, self._ran = max_checks, limit, pace, 0, False
        self._last = time.perf_counter()

    def another(self, state: SearchState | ShorteningState) -> bool:
        """Whether there is another slice; if so, ``state.until`` is set."""
        now, stopped = time.perf_counter(), getattr(_here, "stopped", None)
        if stopped is not None and stopped.is_set():
            raise StoppedError
        if self._ran:
            self._limit.begin(now)
        if state.checks >= self._most or self._limit.is_over():
            return False
        checks = int(state.checks)
        if self._ran:
            self._pace.adapt(now - self._last, checks - self._before)
        self._last, self._before, self._ran = now, checks, True
        state.until = min(self._most, checks + self._pace.checks)
        return True

    def go_over(self, checks: int) -> None:
        """From a search, which ended after so many checked edges, to the shortening of its path, which ends by itself."""
        self._before -= checks
        self._most, self._limit = 2**62, TimeLimit(None)
