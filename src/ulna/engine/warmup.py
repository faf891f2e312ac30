"""Compiles every entry ahead, so that no call waits for the compiler."""

import atexit
import multiprocessing
import os
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack
from typing import NamedTuple

from ulna.engine.announcements import Announcements, quietly
from ulna.engine.compiler import numba_types
from ulna.engine.decorators import ENTRIES, is_plain
from ulna.engine.entries import Entries
from ulna.engine.signatures import NONE, parts_of


class Job(NamedTuple):
    """One signature of an entry: the package, the entry's name there, and the index of the signature."""

    entries: Entries
    name: str
    signature: int

    @property
    def is_together(self) -> bool:
        """Whether the entry is compiled in the same process as others that call the same long kernels."""
        return self.entries.are_together(self.name)


class Compiled(NamedTuple):
    """The time of a job [s], and whether the machine code was on disk already.

    shapes: "boxes" or "any" for an entry that is compiled twice, else "".
    """

    name: str
    shapes: str
    seconds: float
    was_cached: bool


def all_jobs(entries: Entries) -> list[Job]:
    """Every signature of every entry; the longest jobs, estimated by their numbers of arguments, come first."""
    if is_plain():
        return []
    jobs = [
        (-k, -len([*parts_of(signature)]), Job(entries, name, k))
        for name in entries.names()
        for k, signature in enumerate(ENTRIES[entries.marked(name)].signatures)
    ]
    return [job for _, _, job in sorted(jobs, key=lambda job: (*job[:2], job[2].name))]


def compile_all(jobs: list[Job], *, side_by_side: bool) -> Iterator[Compiled]:
    """Run the jobs in one process or in two; yields the results in the order of completion.

    A kernel that several entries call is translated once in each process. So the entries that are ``COMPILED_TOGETHER`` go to one
    process, and the others to the other. The process that finishes first takes the other's last jobs.
    """
    if not side_by_side:
        with quietly():
            yield from map(compile_one, jobs)
        return
    together = deque(job for job in jobs if job.is_together)
    others = deque(job for job in jobs if not job.is_together)
    context = multiprocessing.get_context("spawn")  # a fork of a process that has compiled may deadlock
    with ExitStack() as stack:
        first, second = (stack.enter_context(ProcessPoolExecutor(1, context, initializer=_begin_worker)) for _ in range(2))
        queues = {first: (together, others), second: (others, together)}
        working: dict[Future[Compiled], ProcessPoolExecutor] = {}
        free = [first, second]
        while free or working:
            for process in free:
                own, of_other = queues[process]
                if own or of_other:
                    working[process.submit(compile_one, own.popleft() if own else of_other.pop())] = process
            done = wait(working, return_when=FIRST_COMPLETED).done
            free = [working.pop(future) for future in done]
            yield from (future.result() for future in done)


def compile_one(job: Job) -> Compiled:
    """Compile an entry for one signature, or load its machine code from disk."""
    start, entry = time.perf_counter(), job.entries.marked(job.name)
    signatures = ENTRIES[entry].signatures
    signature = numba_types(signatures[job.signature])
    hits = entry.stats.cache_hits[signature]
    entry.compile(signature)
    shapes = "" if len(signatures) == 1 else "boxes" if NONE in parts_of(signatures[job.signature]) else "any"
    seconds, was_cached = time.perf_counter() - start, entry.stats.cache_hits[signature] > hits
    return Compiled(job.name.rpartition(".")[2], shapes, seconds, was_cached)


def _begin_worker() -> None:
    """Announce nothing in this process, and end it at once when its work is done.

    Otherwise Python would first spend seconds to free all objects of the compiler. A process without a parent is the caller's
    own, and stays unchanged.
    """
    Announcements.enabled = False
    if multiprocessing.parent_process() is not None:
        atexit.register(os._exit, 0)
