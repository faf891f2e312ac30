"""Starts and ends programs in tests, and waits for their output."""

import contextlib
import itertools
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

PATIENCE_S = 240.0  # with a program that is told to end: one that takes longer never does
LOOKS = 3000  # for what is waited for, some five minutes: a program that starts on a busy machine takes one

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # of a shell's background job; what is started here would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)


@contextlib.contextmanager
def running(*command: str, end_with: signal.Signals = signal.SIGINT, **options) -> Iterator[subprocess.Popen]:
    """A program beside the test, in a group of its own. It ends with the block, and nothing that it started outlives it.

    One that does not end at the signal is killed, and the test has failed.
    """
    program = subprocess.Popen(command, start_new_session=True, text=True, **options)
    try:
        yield program
    finally:
        program.send_signal(end_with)
        killed = False
        try:
            program.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            killed = True
            program.kill()
            program.communicate()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
    assert not killed, f"{' '.join(command)}: did not end within {PATIENCE_S:g} s of {end_with.name}, and was killed"


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def wait_for(condition: Callable[[], object], what: str, looks: int | None = LOOKS, pause: Callable[[], object] | None = None):
    """Wait until something holds, and return it.

    Args:
        condition: What is looked at.
        what: In words.
        looks: How often; None for what is compiled, which takes as long as it takes.
        pause: Waits between two looks, for the machine's next step; a tenth of a second unless given.
    """
    for look in itertools.count(1):
        if found := condition():
            return found
        assert looks is None or look < looks, f"not seen in {looks} looks: {what}"
        (pause or _a_moment)()
    return None


def _a_moment() -> None:
    time.sleep(0.1)


# Runs the program of its arguments, with a compiler that never ends and leaves Python to the other threads as a real one does.
ENDLESS_COMPILER = """
import runpy, sys
from ulna.engine import cache
announce = cache.compilation_begins
def compile_without_end(name):
    announce(name)
    while True:
        pass
cache.compilation_begins = compile_without_end
sys.argv.pop(0)
if sys.argv[0] == "-m":
    sys.argv.pop(0)
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
else:
    runpy.run_path(sys.argv[0], run_name="__main__")
"""


def ends_while_it_compiles(program: list[str], environment: dict[str, str], cache: Path, **options) -> None:
    """Assert that a program with an empty cache of kernels ends well at Ctrl-C while a compilation runs that it announced.

    Args:
        program: A script and its arguments, or ``-m``, a module and its arguments.
        environment: Its environment.
        cache: An empty folder, for the kernels and what the program prints.
        **options: As of ``subprocess.Popen``.
    """
    printed, own = cache / "printed", {**environment, "NUMBA_CACHE_DIR": str(cache)}
    command = (sys.executable, "-c", ENDLESS_COMPILER, *program)
    with printed.open("w") as output, running(*command, env=own, stdout=output, stderr=subprocess.STDOUT, **options) as process:
        wait_for(lambda: re.search(r"compiling \w+", printed.read_text()), "what is compiled")
    assert process.returncode == 0, printed.read_text()
    assert "Traceback" not in printed.read_text()
