"""Times a first use on a machine without machine code."""

from tempfile import TemporaryDirectory

from benchmarks.first_use import time_steps


def cold_rows():
    """Seconds of each step of a first use with an empty cache, which compiles everything that the steps call."""
    with TemporaryDirectory() as folder:
        return [{"step": step, "seconds": seconds} for step, seconds in time_steps(NUMBA_CACHE_DIR=folder).items()]
