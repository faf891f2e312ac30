"""Lets Ctrl-C end the command line while it imports, without a traceback; it imports next to nothing itself."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_INTERRUPTED = 130  # the exit status of Ctrl-C


@contextmanager
def quiet_imports() -> Iterator[None]:
    """A context for imports: Ctrl-C in it ends the process with status 130.

    An exception would not do: it may be raised in an import of C, or in a callback, which prints it and goes on.
    """
    is_default = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not is_default or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: os._exit(_INTERRUPTED))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
