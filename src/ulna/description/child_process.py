"""Starts a program in a child process and ends it in time.

The program is Ulna's, its input may be a stranger's. So nothing that lies beside the input is run: Python is isolated (``-I``),
in an empty folder of its own, and modules and libraries are searched for in absolute paths only, the interpreter's first.
"""

import json
import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

_LIBRARY_PATHS = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH")  # some Pythons need them to start
_START = """
import json, sys, types
sys.path += [path for path in json.loads(sys.argv[2]) if path not in sys.path]
ulna = sys.modules["ulna"] = types.ModuleType("ulna")
ulna.__path__ = [sys.argv[1]]
from {module} import main
main()
"""  # the package without running its __init__, which would import NumPy


def program_of(module: str) -> str:
    """The program that calls the function ``main`` of a module of this package."""
    return _START.format(module=module)


@contextmanager
def child_process(program: str, memory: int, seconds: float) -> Iterator[tuple[subprocess.Popen, threading.Event]]:
    """A child process, and the event that its time is over. It has no environment variables of the user.

    Args:
        program: Its text. Its last argument is the limits in JSON, which it sets itself (``xacro.child.confinement``).
        memory: Bytes of address space.
        seconds: How long it may run; then it is killed.
    """
    paths = [path for path in sys.path if isinstance(path, str) and os.path.isabs(path)]  # noqa: PTH117 - text in, text out
    arguments = [str(Path(__file__).parents[1]), json.dumps(paths), json.dumps({"memory": memory, "seconds": seconds})]
    command = [sys.executable, "-I", "-X", "utf8", "-c", program, *arguments]
    pipe = subprocess.PIPE
    late = threading.Event()
    with TemporaryDirectory(prefix="ulna-") as folder:
        child = subprocess.Popen(command, env=_environment(), cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe)  # noqa: S603 - our module

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
    """The last line that a child wrote to its standard error, safe to print on a terminal; else its exit status."""
    lines = errors.decode(errors="replace").strip().splitlines()
    return printable(lines[-1]) if lines else f"exit status {child.returncode}"


def printable(text: str) -> str:
    """Text with escapes in place of control characters."""
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)


def _environment() -> dict[str, str]:
    """What a Python needs to start. An empty element of a path of libraries would be the current folder."""
    kept = {name: os.environ[name] for name in ("SYSTEMROOT",) if name in os.environ}
    for name in _LIBRARY_PATHS:
        elements = re.split("[:;]", os.environ.get(name, ""))
        absolute = [element for element in elements if element.startswith("/")]
        if absolute:
            kept[name] = ":".join(absolute)
    return kept
