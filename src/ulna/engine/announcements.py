"""Says that machine code is being made, which takes a second to half a minute.

On a terminal each entry is announced as its compilation begins. Elsewhere (a pipe, CI, Jupyter) a chain of compilations is
announced once: those that one call waits for. That is a record of the logger ``ulna``, level INFO. A program that shows records
decides itself what becomes of it; one that shows none, or writes them only into a file, gets a line on standard error.
"""

import contextlib
import logging
import sys
import threading
import time

LOGGER = logging.getLogger("ulna")
LOGGER.addHandler(logging.NullHandler())
_NEXT_WITHIN_S = 2.0  # of the end of a compilation the next of a chain begins
_LONGEST_S = 120.0  # of one compilation
_lock = threading.Lock()
_chain_until = 0.0


class Announcements:
    """Whether compilations are announced."""

    enabled = True


@contextlib.contextmanager
def quietly():
    """Within it nothing is announced: who compiles ahead shows its own progress."""
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
    if on_terminal:
        _print(f"ulna: compiling {name} for this machine (once)")
    if begins_chain:
        line = f"compiling {name} and what is called with it for this machine (once; `ulna warmup` compiles everything)"
        LOGGER.info(line)
        if not on_terminal and not _shows_records():
            _print(f"ulna: {line}")


def compilation_ended() -> None:
    """What follows soon is of the same chain."""
    _prolong(_NEXT_WITHIN_S, ended=True)


def _prolong(seconds: float, *, ended: bool = False) -> bool:
    """Let the chain go on for so long from now. Returns whether it begins now."""
    global _chain_until
    with _lock:
        now = time.monotonic()
        begins, _chain_until = now >= _chain_until, now + seconds if ended else max(_chain_until, now + seconds)
        return begins


def _shows_records() -> bool:
    """Whether the program, or what it runs in, shows records: a handler here or of the root that writes not only into a file."""
    handlers = (*LOGGER.handlers, *logging.getLogger().handlers)
    return not all(isinstance(handler, logging.NullHandler | logging.FileHandler) for handler in handlers)


def _print(line: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # standard error is closed, or None
        print(line, file=sys.stderr, flush=True)  # noqa: T201
