"""Times calls by the median of interleaved passes (A B A B ...) over many inputs, and describes the machine.

A pass calls a function once for each input, so that the caches do not hold the data of the call before. The
cost of the loop, measured in the same way with an empty body, is subtracted. The first pass of each function warms it up
(compiles it, if needed) and is not counted. Keep a pass below one or two milliseconds. On a busy machine other work interrupts
longer passes, and distorts their times.
"""

import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter_ns
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.ahead import is_ahead, level
from ulna.engine.processors import n_processors

PACKAGES = ("numpy", "numba", "llvmlite")


def machine_facts() -> dict[str, object]:
    """The processor, the number of usable cores, the kernels' register width and origin, and the versions."""
    from ulna.engine.processors import register_bits  # noqa: PLC0415 -- it loads the compiler, which other commands may not need

    return {
        "processor": processor_name(),
        "cores": n_processors(),
        "register_bits": register_bits(),
        "machine_code": f"ahead ({level()})" if is_ahead() else "compiled here",
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "ulna": installed_version("ulna"),
        **{name: installed_version(name) for name in PACKAGES},
    }


def installed_version(name: str) -> str:
    """The version of an installed package, or "absent"."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def processor_name() -> str:
    """The processor's name: on Linux from /proc/cpuinfo, elsewhere from Python."""
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


class Workload(NamedTuple):
    """A function of one argument, the arguments for its calls, and the number of problems that one call solves."""

    function: Callable
    inputs: Sequence
    problems: int = 1


@dataclass(frozen=True)
class Timing:
    """Quartiles of the time of one problem [ns] over the passes, and the times of all passes, shape (passes,)."""

    lower: float
    median: float
    upper: float
    passes: NDArray[np.float64]


def time_interleaved(workloads: Mapping[str, Workload], passes: int = 21) -> dict[str, Timing]:
    """Time one problem of each workload; the workloads take turns, pass by pass.

    Example:
        >>> slow, quick = Workload(lambda n: sum(range(n)), [4000] * 9), Workload(lambda n: None, [4000] * 9)
        >>> timings = time_interleaved({"slow": slow, "quick": quick}, passes=5)
        >>> timings["slow"].median > timings["quick"].median
        True
    """
    for workload in workloads.values():
        one_pass(workload)
    times = np.array([[one_pass(workload) for workload in workloads.values()] for _ in range(passes)])
    return {name: _timing(times[:, k]) for k, name in enumerate(workloads)}


def one_pass(workload: Workload) -> float:
    """The time of one problem [ns]: the mean over a pass, minus the cost of the loop."""
    function = workload.function
    start = perf_counter_ns()
    for argument in workload.inputs:
        function(argument)
    between = perf_counter_ns()
    for argument in workload.inputs:  # noqa: B007 -- the loop alone is timed
        pass
    end = perf_counter_ns()
    return max(0.0, float((between - start) - (end - between))) / (len(workload.inputs) * workload.problems)


def time_each(function: Callable, inputs: Sequence[tuple], passes: int = 3) -> NDArray[np.float64]:
    """The time of ``function(*inputs[k])`` for each k [ns]: the median over the passes, minus the clock's cost."""
    function(*inputs[0])
    times = np.empty((passes, len(inputs)))
    for row in times:
        for k, arguments in enumerate(inputs):
            start = perf_counter_ns()
            function(*arguments)
            row[k] = perf_counter_ns() - start
    return np.maximum(0.0, np.median(times, axis=0) - _clock_cost())


def _clock_cost() -> float:
    """The time between two consecutive readings of the clock [ns]."""
    return float(np.median([-(perf_counter_ns() - perf_counter_ns()) for _ in range(1000)]))


def _timing(passes: NDArray[np.float64]) -> Timing:
    lower, median, upper = np.percentile(passes, (25, 50, 75))
    return Timing(float(lower), float(median), float(upper), passes)
