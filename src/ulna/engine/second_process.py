"""Starts a second process that compiles entries while this one compiles those that the program calls.

The first use of a clone compiles one entry after another, in the order of the program's calls. Planning takes half of that time.
So at the first compilation a second process begins on another processor, with the longest entries (``fill``). It writes machine
code to the cache, and locks a file there for each entry that it compiles. This process waits for a locked entry, and then loads
it. The second process ends with this one, or when the cache has every entry.

None begins with one thread (``ulna.threads(1)`` or ``ULNA_THREADS=1``), in a process of ``multiprocessing``, in a program that
contains its own Python, or with ``ULNA_WARMUP=0``. A failure to start it has no effect.
"""

import contextlib
import multiprocessing
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

from ulna.engine.child_program import command_of, program_of
from ulna.engine.private_folder import PrivateFolder
from ulna.engine.threads import n_threads

VARIABLE = "ULNA_WARMUP"
FILLING = "filling.lock"  # locked by the second process of any program
_LONGEST_S = 120.0  # more than any entry takes to compile
_PYTHON = re.compile(r"python[\d.]*t?w?(_d)?(\.exe)?", re.IGNORECASE)
_DETACH = "import subprocess, sys; subprocess.Popen(sys.argv[1:])"


def lock_of(file: str) -> str:
    """The name of the file that is locked while another file of the cache is being compiled."""
    return f"{file}.lock"


def is_compiled_elsewhere(file: str, folder: PrivateFolder) -> bool:
    """Start the second process of a cache, once, and wait while any compiles a file. Returns whether one did.

    At the end of ``_LONGEST_S`` the wait ends too, in case the second process is stopped.
    """
    if os.environ.get(VARIABLE, "1") not in {"", "1"}:
        return False
    _begin(folder)
    with contextlib.suppress(OSError):
        return folder.wait_for(lock_of(file), _LONGEST_S)
    return False


@cache
def _begin(folder: PrivateFolder) -> None:
    with contextlib.suppress(Exception):  # it only saves time
        if _may_begin() and not folder.is_locked(FILLING):
            _start()


def _may_begin() -> bool:
    is_python = _PYTHON.fullmatch(Path(sys.executable).name) is not None and not getattr(sys, "frozen", False)
    is_program = multiprocessing.parent_process() is None
    return is_python and is_program and n_threads() > 1


def _start() -> None:
    """Start the second process by a third one, which ends at once.

    So it is no child of this process, which may wait for all of its children. It reads from a pipe whose other end stays open
    until this process ends.
    """
    end, _ = os.pipe()
    try:
        command = [sys.executable, "-I", "-S", "-c", _DETACH, *command_of(program_of("ulna.engine.fill"))]
        subprocess.run(  # noqa: S603 - our own program
            command,
            env={**os.environ, VARIABLE: "0"},
            stdin=end,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    finally:
        os.close(end)
