"""Divides a search into slices, so that Ctrl-C, a time limit or a failure in another thread can end it."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from ulna.errors import UlnaError
from ulna.ik.time_limit import TimeLimit
from ulna.planning.entries.search_records import SearchState, ShorteningState

MAX_CHECKS = 2**62 - 1
_FIRST_SLICE, _LONGEST_SLICE = 64, 0.02  # checked edges; seconds
_MAX_GROWTH = 16.0  # maximum ratio of a slice to the previous one
_here = threading.local()


class StoppedError(UlnaError):
    """A search was ended because another search failed, or by Ctrl-C in another thread."""


@contextmanager
def stopping(event: threading.Event) -> Iterator[None]:
    """A context in which searches of this thread end with a ``StoppedError`` once an event is set."""
    _here.stopped = event
    try:
        yield
    finally:
        _here.stopped = None


class Pace:
    """The number of checked edges per slice, adapted to take about 10 ms.

    Attributes:
        checks: The number for the next slice.
    """

    def __init__(self) -> None:
        self.checks = _FIRST_SLICE

    def adapt(self, seconds: float, checks: int) -> None:
        """Adapt the number to the measured time of the last slice's checked edges."""
        wanted = 0.5 * _LONGEST_SLICE * max(1, checks) / max(seconds, 1e-9)
        self.checks = max(1, int(min(max(wanted, self.checks / 2), _MAX_GROWTH * self.checks)))


class Slices:
    """The slices of a run, between which Ctrl-C and a time limit take effect.

    The result does not depend on the division into slices.
    """

    def __init__(self, max_checks: int, limit: TimeLimit, pace: Pace) -> None:
        self._most, self._limit, self._pace, self._before, self._ran = max_checks, limit, pace, 0, False
        self._last = time.perf_counter()

    def begin_slice(self, state: SearchState | ShorteningState) -> bool:
        """Begin the next slice by setting ``state.until``; False if the budget or the time is over.

        Raises:
            StoppedError: The event of ``stopping`` is set.
        """
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

    def start_shortening(self, checks: int) -> None:
        """Switch to shortening, which needs no budget. checks: the number of edges that the search checked."""
        self._before -= checks
        self._most, self._limit = 2**62, TimeLimit(None)
