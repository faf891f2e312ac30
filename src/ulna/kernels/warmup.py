"""Every entry compiled ahead, so that no call waits for the compiler."""

import importlib
import pkgutil
import time
from collections.abc import Iterator
from typing import NamedTuple

import ulna.kernels
from ulna.kernels.compile import ENTRIES


class Compiled(NamedTuple):
    """An entry for one kind of call: its name, the seconds that it took, and whether its machine code was on disk already."""

    name: str
    seconds: float
    was_cached: bool


def count_entries() -> int:
    """How many there are to compile: an entry counts once for each kind of call."""
    for module in pkgutil.iter_modules(ulna.kernels.__path__):
        importlib.import_module(f"ulna.kernels.{module.name}")
    return sum(map(len, ENTRIES.values()))


def compile_entries() -> Iterator[Compiled]:
    """Compile each, or load what is on disk."""
    count_entries()
    for entry, calls in list(ENTRIES.items()):
        for call in calls:
            start = time.perf_counter()
            before = sum(entry.stats.cache_hits.values())
            entry.compile(tuple(call))
            hit = sum(entry.stats.cache_hits.values()) > before
            yield Compiled(entry.py_func.__name__, time.perf_counter() - start, hit)
