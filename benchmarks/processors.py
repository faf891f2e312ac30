"""How many processors what is timed may use."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ulna.engine.threads import default_threads


@contextmanager
def one_processor() -> Iterator[None]:
    """Keep what is called here to one processor, where the system can: Ulna then hands nothing to threads."""
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
    os.sched_setaffinity(0, processors)  # of this thread and those that it begins; those that are there already keep theirs
    default_threads.cache_clear()
