"""Compiles what the cache lacks: the program of the second process (``second_process``).

It compiles entries for boxes before those for all shapes, and those with more arguments first. It ends with the program that
started it.
"""

import contextlib
import os
import signal
import threading
from pathlib import Path

from ulna.engine.announcements import quietly
from ulna.engine.cache import cache_folder
from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES
from ulna.engine.entries import Entries
from ulna.engine.private_folder import PrivateFolder
from ulna.engine.second_process import FILLING, lock_of
from ulna.engine.warmup import Job, all_jobs


def main() -> None:
    """Compile every entry, and end this process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C in a terminal is for the program
    threading.Thread(target=_end_with_the_program, daemon=True).start()
    _give_way()
    try:
        folder = cache_folder()
        if folder is not None and folder.lock(FILLING) is not None:
            with quietly():
                for job in sorted(all_jobs(Entries("ulna")), key=lambda job: job.signature):
                    _compile(job, folder)
    finally:
        os._exit(0)  # Python would first spend seconds to free all objects of the compiler


def _compile(job: Job, folder: PrivateFolder) -> None:
    entry = job.entries.marked(job.name)
    signature = numba_types(ENTRIES[entry].signatures[job.signature])
    file = entry._cache.file_of(signature, entry.targetctx)  # noqa: SLF001 - our own cache
    if folder.has(file):
        return
    lock = folder.lock(lock_of(file))
    if lock is not None:
        entry.compile(signature)
        os.close(lock)


def _end_with_the_program() -> None:
    """End this process when the program has closed its end of the pipe."""
    os.read(0, 1)  # nothing is written to the pipe
    os._exit(0)


def _give_way() -> None:
    """Run at the usual priority, and end first if memory is short."""
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")
