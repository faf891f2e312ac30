"""Lets Ctrl-C end the command line during imports, without a traceback; imports almost nothing itself."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_INTERRUPTED = 130  # the exit status of Ctrl-C


@contextmanager
def quiet_imports() -> Iterator[None]:
    """Within the block, Ctrl-C ends the process with status 130.

    An exception is not enough. Python may raise it in an import in C, or in a callback that prints it and continues.
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
