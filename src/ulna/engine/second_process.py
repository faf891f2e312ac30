"""Starts a second process that compiles the longest entries while this one compiles those that the program calls.

The first use of a clone compiles one entry after another, in the order of the program's calls. Planning takes half of that time.
So at the first compilation a second process begins on another core with the longest entries (``warmup.fill_cache``). It writes
machine code to the cache, where this process finds it. The two processes tell each other what they compile, so that neither
compiles what the other does. The second process ends with this one, or when the cache has every entry.

None is started with one thread (``ulna.threads(1)``), within a process of ``multiprocessing``, or with ``ULNA_WARMUP=0``.
"""

import atexit
import contextlib
import json
import multiprocessing
import os
import subprocess
import sys
import threading
from functools import cache
from pathlib import Path

from ulna.engine.threads import n_threads

_VARIABLE = "ULNA_WARMUP"
_FILL = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from ulna.engine.warmup import fill_cache; fill_cache()"


def is_compiled_there(file: str) -> bool:
    """Wait while the second process compiles an entry; if it does not, tell it to leave this entry out.

    The first call starts the second process.

    Args:
        file: The name of the entry's file in the cache.

    Returns:
        Whether the second process has compiled the entry meanwhile.
    """
    second = _second_process()
    return second is not None and second.compiles(file)


@cache
def _second_process() -> "_SecondProcess | None":
    is_python = Path(sys.executable or "").name.lower().startswith("python")  # not a program with Python inside
    is_program = is_python and multiprocessing.parent_process() is None
    if is_program and os.environ.get(_VARIABLE) != "0" and n_threads() > 1:
        with contextlib.suppress(OSError):
            return _SecondProcess()
    return None


class _SecondProcess:
    """A process that compiles. It writes the name of each file that it begins, and reads the names of files to leave out."""

    def __init__(self) -> None:
        path = [str(Path(__file__).parents[2]), *(folder for folder in sys.path if folder)]
        self._process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-I", "-c", _FILL, json.dumps(path)],
            env={**os.environ, _VARIABLE: "0"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
        )
        self._of, self._changed, self._current = os.getpid(), threading.Condition(), ""
        threading.Thread(target=self._read, name="ulna-second-process", daemon=True).start()
        atexit.register(self._end)

    def compiles(self, file: str) -> bool:
        """Wait while it compiles a file, and return True; otherwise tell it to leave the file out."""
        if os.getpid() != self._of:  # a fork has no thread that reads
            return False
        with self._changed:
            if self._current == file:
                self._changed.wait_for(lambda: self._current != file)
                return True
        with contextlib.suppress(OSError, ValueError):  # it has ended
            print(file, file=self._process.stdin, flush=True)
        return False

    def _read(self) -> None:
        for line in self._process.stdout or ():
            self._begin(line.strip())
        self._begin("")
        self._process.wait()

    def _begin(self, file: str) -> None:
        with self._changed:
            self._current = file
            self._changed.notify_all()

    def _end(self) -> None:
        if os.getpid() == self._of:
            self._process.kill()
            self._process.wait()
