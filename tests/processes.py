"""Programs that a test starts and ends, and waiting for what they do."""

import contextlib
import itertools
import os
import re
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

PATIENCE_S = 240.0  # with a program that is told to end: one that takes longer never does
TRIES = 5
LOOKS = 600  # for what is waited for; a slow machine looks more slowly

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


def ended_in_the_middle(command: list[str], environment: dict[str, str], folder: Path, **options) -> bool:
    """Whether a program with an empty cache of kernels ends at Ctrl-C before the entry is compiled that it announces.

    It must end well, and without a traceback. On a busy machine the entry may be compiled before the signal arrives: then the
    program is run again, a few times. One that waits for its compiler has the entry in the cache every time.
    """
    for attempt in range(TRIES):
        cache = folder / str(attempt)
        cache.mkdir()
        printed, own = cache / "printed", {**environment, "NUMBA_CACHE_DIR": str(cache)}
        with (
            printed.open("w") as output,
            running(*command, env=own, stdout=output, stderr=subprocess.STDOUT, **options) as program,
        ):
            announced = wait_for(lambda: re.search(r"compiling (\w+)", printed.read_text()), "what is compiled")  # noqa: B023
        assert program.returncode == 0, printed.read_text()
        assert "Traceback" not in printed.read_text()
        if not list(cache.rglob(f"*{announced[1]}*")):
            return True
    return False
