"""Announces compilations, which take a second to half a minute.

On a terminal a line names the entry and counts the seconds, and shows the total at the end. While a progress bar is drawn there,
the line is printed once instead. Elsewhere (a pipe, CI, Jupyter) a chain of compilations for one call is announced once, as a
record of the logger ``ulna``, level INFO. A program that shows records decides itself what to do with it. If no handler shows
records, or all write to files only, a line goes to standard error.
"""

import contextlib
import itertools
import logging
import os
import sys
import threading
import time

from ulna.engine.progress import is_bar_shown

LOGGER = logging.getLogger("ulna")
LOGGER.addHandler(logging.NullHandler())
_NEXT_WITHIN_S = 2.0  # maximum pause between two compilations of a chain
_LONGEST_S = 120.0  # maximum duration of one compilation
_CLEAR = "\r\x1b[K"  # clears the current line of the terminal
_TURN_S = 0.2
_lock = threading.Lock()
_chain_until = 0.0


class Announcements:
    """Whether compilations are announced."""

    enabled = True


@contextlib.contextmanager
def quietly():
    """Within the block, announce nothing: a caller that compiles ahead shows its own progress."""
    before, Announcements.enabled = Announcements.enabled, False
    try:
        yield
    finally:
        Announcements.enabled = before


def compilation_begins(name: str) -> None:
    """Announce the compilation of an entry."""
    if not Announcements.enabled:
        return
    begins_chain = _prolong(_LONGEST_S)
    on_terminal = sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()
    if on_terminal and (is_bar_shown() or os.environ.get("TERM") == "dumb"):
        _print(f"ulna: compiling {name} for this machine (once)")
    elif on_terminal:
        _spinner.begin(name)
    if begins_chain:
        line = f"compiling {name} and its callees for this machine (once; `ulna warmup` compiles everything)"
        LOGGER.info(line)
        if not on_terminal and not _shows_records():
            _print(f"ulna: {line}")


def compilation_ended(name: str = "") -> None:
    """Mark the end of a compilation; one that follows soon belongs to the same chain."""
    _spinner.end(name)
    _prolong(_NEXT_WITHIN_S, ended=True)


def _prolong(seconds: float, *, ended: bool = False) -> bool:
    """Extend the chain by a time from now; returns whether it begins now."""
    global _chain_until
    with _lock:
        now = time.monotonic()
        begins, _chain_until = now >= _chain_until, now + seconds if ended else max(_chain_until, now + seconds)
        return begins


def _shows_records() -> bool:
    """Whether any handler, here or of the root logger, shows records other than in a file."""
    handlers = (*LOGGER.handlers, *logging.getLogger().handlers)
    return not all(isinstance(handler, logging.NullHandler | logging.FileHandler) for handler in handlers)


def _print(line: str, end: str = "\n") -> None:
    with contextlib.suppress(OSError, ValueError):  # standard error is closed, or None
        print(line, end=end, file=sys.stderr, flush=True)  # noqa: T201


class _Spinner:
    """A line of a terminal that names the current compilation and its duration."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._since: dict[str, float] = {}  # start times, by the name of the entry
        self._thread: threading.Thread | None = None

    def begin(self, name: str) -> None:
        """Show that an entry is being compiled."""
        with self._lock:
            self._since[name] = time.monotonic()
            if self._thread is None:
                self._thread = threading.Thread(target=self._turn, name="ulna-spinner", daemon=True)
                self._thread.start()

    def end(self, name: str) -> None:
        """Show the duration of a compilation."""
        with self._lock:
            since = self._since.pop(name, None)
            if since is not None:
                _print(f"{_CLEAR}ulna: compiled {name} for this machine (once): {time.monotonic() - since:.1f} s")

    def _turn(self) -> None:
        turns = itertools.cycle("|/-\\")
        while True:
            with self._lock:
                now = time.monotonic()
                self._since = {name: since for name, since in self._since.items() if now - since < _LONGEST_S}  # failed ones
                if not self._since:
                    self._thread = None
                    return
                name, since = list(self._since.items())[-1]
                words = f"compiling {name} for this machine (once), {now - since:.0f} s"
                _print(f"{_CLEAR}ulna: {next(turns)} {words}", end="")
            time.sleep(_TURN_S)


_spinner = _Spinner()
