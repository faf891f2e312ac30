"""Starts a program in a child process and ends it in time.

The program is Ulna's, but its input may come from a stranger. So nothing next to the input is executed. Python is isolated
(``-I``) and runs in an empty folder of its own. It searches modules and libraries in absolute paths only, the interpreter's
first.
"""

import json
import os
import re
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import TemporaryDirectory

from ulna.engine.child_program import command_of

_LIBRARY_PATHS = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")  # some Pythons need them to start


@contextmanager
def child_process(program: str, memory: int, seconds: float) -> Iterator[tuple[subprocess.Popen, threading.Event]]:
    """A child process without the user's environment variables, and an event that is set when its time is over.

    Args:
        program: Its text. Its last argument is the limits in JSON, which it sets itself (``xacro.child.confinement``).
        memory: Bytes of address space.
        seconds: Its time limit; afterwards it is killed.
    """
    command = command_of(program, json.dumps({"memory": memory, "seconds": seconds}))
    pipe = subprocess.PIPE
    late = threading.Event()
    with TemporaryDirectory(prefix="ulna-") as folder:
        child = subprocess.Popen(command, env=_environment(), cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe)  # noqa: S603

        def end() -> None:
            late.set()
            child.kill()

        timer = threading.Timer(seconds, end)
        timer.daemon = True
        timer.start()
        try:
            yield child, late
        finally:
            timer.cancel()
            child.kill()
            child.communicate()


def last_words(child: subprocess.Popen, errors: bytes) -> str:
    """The last line of a child's standard error, safe to print on a terminal; without one its exit status."""
    lines = errors.decode(errors="replace").strip().splitlines()
    return printable(lines[-1]) if lines else f"exit status {child.returncode}"


def printable(text: str) -> str:
    """Text with escapes in place of control characters."""
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)


def _environment() -> dict[str, str]:
    """The environment that Python needs to start; an empty element of a library path would mean the current folder."""
    kept = {name: os.environ[name] for name in ("SYSTEMROOT",) if name in os.environ}
    for name in _LIBRARY_PATHS:
        elements = re.split("[:;]", os.environ.get(name, ""))
        absolute = [element for element in elements if element.startswith("/")]
        if absolute:
            kept[name] = ":".join(absolute)
    return kept
