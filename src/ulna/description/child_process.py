"""Starts a program in a child process and ends it in time. Used by ``xacro.process`` and ``meshes.decompose``."""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_KEPT = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "PYTHONHOME", "SYSTEMROOT")  # some Pythons need them to start
_START = """
import sys, types
ulna = sys.modules["ulna"] = types.ModuleType("ulna")
ulna.__path__ = [sys.argv[1]]
from {module} import main
main()
"""  # the package without running its __init__, which would import NumPy


def program_of(module: str) -> str:
    """The program that calls the function ``main`` of a module of this package."""
    return _START.format(module=module)


@contextmanager
def child_process(
    program: str, memory: int, seconds: float, folder: Path | None
) -> Iterator[tuple[subprocess.Popen, threading.Event]]:
    """A child process, and the event that its time is over. It has no environment variables of the user.

    Args:
        program: Its text. Its last argument is the limits in JSON, which it sets itself (``xacro.child.confinement``).
        memory: Bytes of address space.
        seconds: How long it may run; then it is killed.
        folder: Its working directory; this process's unless given.
    """
    command = [sys.executable, "-P", "-c", program, str(Path(__file__).parents[1])]
    command.append(json.dumps({"memory": memory, "seconds": seconds}))
    environment = {name: os.environ[name] for name in _KEPT if name in os.environ}
    environment |= {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONUTF8": "1"}
    pipe = subprocess.PIPE
    child = subprocess.Popen(command, env=environment, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe)  # noqa: S603 - our module
    late = threading.Event()

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
