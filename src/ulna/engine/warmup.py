"""Every entry compiled ahead, so that no call waits for the compiler."""

import gc
import importlib
import multiprocessing
import pkgutil
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import ExitStack
from typing import Any, NamedTuple

import ulna.kernels
from ulna.engine import cache
from ulna.engine.decorators import ENTRIES, is_plain
from ulna.engine.signatures import NONE

_RARELY = 50_000  # objects more than before, until what nobody holds is looked for: a compilation makes millions that are held
_OF_TWO_BODIES_IN_LANES = (
    "ulna.kernels.collision.continuous",
    "ulna.kernels.collision.nearest",
    "ulna.kernels.collision.overlap",
)


class Job(NamedTuple):
    """One kind of call of an entry: where the entry stands, its name, and which of its calls."""

    module: str
    name: str
    call: int


class Compiled(NamedTuple):
    """What a job took [s], and whether the machine code was on disk already.

    shapes: "boxes" or "any" for an entry that is compiled twice, else "".
    """

    name: str
    shapes: str
    seconds: float
    was_cached: bool


def all_jobs() -> list[Job]:
    """Every kind of call of every entry; those that take longest, by the number of their arguments, first."""
    if is_plain():
        return []
    for module in pkgutil.iter_modules(ulna.kernels.__path__):
        importlib.import_module(f"{ulna.kernels.__name__}.{module.name}")
    jobs = [(-k, -len(call), Job(*_place(entry), k)) for entry, calls in ENTRIES.items() for k, call in enumerate(calls)]
    return [job for _, _, job in sorted(jobs)]


def compile_all(jobs: list[Job], *, side_by_side: bool) -> Iterator[Compiled]:
    """Do the jobs, in one process or in two; what each took, in the order in which they end.

    What several entries call is compiled once in each process: so those that need the distance of two bodies in lanes, which
    takes longest, go to one, and the others to the other.
    """
    if not side_by_side:
        yield from map(compile_one, jobs)
        return
    context = multiprocessing.get_context("spawn")  # a fork of a process that has compiled may hang
    with ExitStack() as stack:
        first, second = (stack.enter_context(ProcessPoolExecutor(1, context, initializer=_begin_quietly)) for _ in range(2))
        working = [(first if job.module in _OF_TWO_BODIES_IN_LANES else second).submit(compile_one, job) for job in jobs]
        for done in as_completed(working):
            yield done.result()


def compile_one(job: Job) -> Compiled:
    """Compile an entry for one kind of call, or load what is on disk."""
    entry = getattr(importlib.import_module(job.module), job.name)
    call = tuple(ENTRIES[entry][job.call])
    start, hits = time.perf_counter(), entry.stats.cache_hits[call]
    entry.compile(call)
    shapes = "" if len(ENTRIES[entry]) == 1 else "boxes" if NONE in call else "any"
    return Compiled(job.name, shapes, time.perf_counter() - start, entry.stats.cache_hits[call] > hits)


def _place(entry: Any) -> tuple[str, str]:
    return entry.py_func.__module__, entry.py_func.__name__


def _begin_quietly() -> None:
    cache.announces = False
    gc.set_threshold(_RARELY)
