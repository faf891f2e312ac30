"""Lets Ctrl-C wait until the compiler is done.

Python raises ``KeyboardInterrupt`` between any two of its instructions. Within LLVM's callbacks it is lost, and the program runs
on. Between taking and releasing llvmlite's lock it leaves the lock taken, and the program waits for ever.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """Within it Ctrl-C waits for the end. A second Ctrl-C ends the program at once, as programs without Python's handler end.

    Only the main thread gets ``KeyboardInterrupt``, so in other threads nothing is changed.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    noted = []

    def note(number, frame):
        noted.append((number, frame))
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if noted:
            handler(*noted[0])
