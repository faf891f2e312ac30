"""Says that machine code is being made, which takes a second to half a minute. Used by ``cache``.

On a terminal each entry is announced as its compilation begins. Elsewhere (a pipe, CI, Jupyter) a chain of compilations is
announced once: those that one call waits for. A program that has configured logging gets that as a record of the logger ``ulna``,
level INFO, and decides itself; one that has not gets a line on standard error.
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
    if begins_chain and _is_configured():
        LOGGER.info("compiling %s and what is called with it for this machine (once; `ulna warmup` compiles everything)", name)
    elif begins_chain and not on_terminal:
        _print(f"ulna: compiling {name} and what is called with it for this machine (once; `ulna warmup` compiles everything)")


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


def _is_configured() -> bool:
    """Whether the program, or what it runs in, handles records: a handler here but our own, or one of the root."""
    return len(LOGGER.handlers) > 1 or logging.getLogger().hasHandlers()


def _print(line: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # standard error is closed, or None
        print(line, file=sys.stderr, flush=True)  # noqa: T201
