"""Restricts a measurement to some processors."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ulna.engine.threads import default_threads


@contextmanager
def one_processor() -> Iterator[None]:
    """Within the block, use one processor, if the system supports it: then Ulna starts no threads."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    _allow({min(allowed)})
    try:
        yield
    finally:
        _allow(allowed)


def _allow(processors: set[int]) -> None:
    os.sched_setaffinity(0, processors)  # of this thread and its new children; existing threads keep theirs
    default_threads.cache_clear()
