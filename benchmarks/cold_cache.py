"""Times a first use on a machine that has no machine code yet."""

from tempfile import TemporaryDirectory

from benchmarks.first_use import time_steps


def cold_rows():
    """Seconds of each step of a first use with an empty cache: all that the steps call is compiled."""
    with TemporaryDirectory() as folder:
        return [{"step": step, "seconds": seconds} for step, seconds in time_steps(NUMBA_CACHE_DIR=folder).items()]
