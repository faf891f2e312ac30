"""Programs that a test starts and ends, and waiting for what they do."""

import contextlib
import os
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator

PATIENCE_S = 60.0  # for a busy machine, and for a first use that compiles

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # of a shell's background job; what is started here would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)


@contextlib.contextmanager
def running(*command: str, end_with: signal.Signals = signal.SIGINT, **options) -> Iterator[subprocess.Popen]:
    """A program beside the test, in a group of its own. It ends with the block, and nothing that it started outlives it."""
    program = subprocess.Popen(command, start_new_session=True, text=True, **options)
    try:
        yield program
    finally:
        program.send_signal(end_with)
        try:
            program.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            program.kill()
            program.communicate()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def wait_for(condition: Callable[[], object], what: str):
    """Wait until something holds, and return it."""
    end = time.monotonic() + PATIENCE_S
    while not (found := condition()):
        assert time.monotonic() < end, f"not seen within {PATIENCE_S:g} s: {what}"
        time.sleep(0.1)
    return found
