"""Times calls and launches on a GPU, with the resources that each driver takes there."""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ulna.gpu import device
from ulna.gpu.device import cuda

IS_SIMULATED = bool(cuda.config.ENABLE_CUDASIM)
_PAUSES, _PAUSE = 10, 50_000  # before a timed launch [ns]: longer than the host prepares it
_WARP, _RESERVED = 32, 1024  # threads of a warp; bytes of shared memory that the driver adds to each block
_LAUNCHES = 5  # calls of which the launches are timed
_TOO_LONG = 20.0  # [s]: calls that together take longer are not repeated


class Limits(NamedTuple):
    """What a multiprocessor has for the blocks that it runs at once: an H100's or H200's by default."""

    threads: int = 2048
    registers: int = 65536
    shared: int = 233472
    blocks: int = 32


class Launched(NamedTuple):
    """A driver that a call has launched: its kernel, the threads of a block, and the time on the device [s]."""

    kernel: Any
    block: int
    seconds: float


class Measured(NamedTuple):
    """A call: its result, its median time [s], and what it launches, by the names of the drivers."""

    found: Any
    seconds: float
    launches: dict[str, Launched]


def measured(work: Callable[[], Any], repeats: int) -> Measured:
    """Measure a call, of which the first compiles. The simulator, whose times mean nothing, makes a single one for 1 repeat."""
    once: list[Any] = []

    def first() -> None:
        once.append(work())

    if IS_SIMULATED and repeats == 1:
        start = time.perf_counter()
        launches = launches_of(first, 1)
        return Measured(once[0], time.perf_counter() - start, launches)
    first()
    return Measured(once[0], seconds_of(work, repeats), launches_of(work, min(repeats, _LAUNCHES)))


def seconds_of(work: Callable[[], Any], repeats: int) -> float:
    """The median time of a call that has run before, including everything that it launches."""
    cuda.synchronize()
    times = []
    while len(times) < repeats and sum(times) < _TOO_LONG:
        start = time.perf_counter()
        work()
        cuda.synchronize()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def launches_of(work: Callable[[], Any], repeats: int) -> dict[str, Launched]:
    """What a call launches: for each driver the median, over the calls, of its time on the device."""
    every: dict[str, list[float]] = defaultdict(list)
    seen: dict[str, tuple[Any, int]] = {}
    end = time.perf_counter() + _TOO_LONG
    for k in range(repeats):
        if k and (not seen or time.perf_counter() > end):
            break
        with _noted() as launches:
            work()
            cuda.synchronize()
        once: dict[str, float] = defaultdict(float)
        for driver, kernel, block, elapsed in launches:
            once[driver.__name__] += elapsed()
            seen[driver.__name__] = kernel, block
        for name, took in once.items():
            every[name].append(took)
    return {name: Launched(*seen[name], float(np.median(times))) for name, times in every.items()}


@contextmanager
def _noted() -> Iterator[list[Any]]:
    """Note each launch: the driver, its kernel, the threads of a block, and a function that returns its time."""
    launches, compiled = [], device.compiled

    class Noted:
        """A compiled driver whose launches are noted."""

        def __init__(self, driver: Any) -> None:
            self.driver, self.kernel = driver, compiled(driver)

        def __getitem__(self, grid: Any) -> Callable[..., None]:
            def launch(*arguments: Any) -> None:
                elapsed = _between(lambda: self.kernel[grid](*arguments), grid[2] if len(grid) > 2 else 0)
                launches.append((self.driver, self.kernel, grid[1], elapsed))

            return launch

    device.compiled = Noted
    try:
        yield launches
    finally:
        device.compiled = compiled


def _between(launch: Callable[[], None], stream: Any) -> Callable[[], float]:
    """Launch something; the time between two events around it on the stream [s]. The simulator has no events: by the host."""
    if IS_SIMULATED:
        start = time.perf_counter()
        launch()
        took = time.perf_counter() - start
        return lambda: took
    begin, end = cuda.event(), cuda.event()
    _pause()[1, 1, stream]()  # otherwise the first event passes while the host still prepares the launch
    begin.record(stream)
    launch()
    end.record(stream)
    return lambda: 1e-3 * cuda.event_elapsed_time(begin, end)


@cache
def _pause() -> Any:
    return cuda.jit(pause)


def pause():
    """Keep a stream busy, by one thread that sleeps."""
    for _ in range(_PAUSES):
        cuda.nanosleep(_PAUSE)


def resources(launched: Launched) -> dict[str, Any]:
    """Registers, local and shared memory of a driver, and the threads of it that a multiprocessor runs at once."""
    if IS_SIMULATED:
        return {}
    kernel, block = launched.kernel, launched.block
    registers, shared = max(kernel.get_regs_per_thread().values()), max(kernel.get_shared_mem_per_block().values())
    limits = _limits()
    at_once = threads_at_once(registers, shared, block, limits)
    return {
        "registers": registers, "local_bytes": max(kernel.get_local_mem_per_thread().values()), "shared_bytes": shared,
        "threads_at_once": at_once, "of_threads": at_once / limits.threads,
    }  # fmt: skip


def threads_at_once(registers: int, shared: int, block: int, limits: Limits) -> int:
    """The number of threads of a driver that a multiprocessor runs at once.

    registers: of a thread, which get eight at a time; shared: bytes of a block; block: the number of its threads.
    """
    warps = -(-block // _WARP)
    of_block = max(1, -(-registers // 8) * 8) * _WARP * warps
    blocks = min(
        limits.threads // (_WARP * warps), limits.registers // of_block, limits.shared // (shared + _RESERVED), limits.blocks
    )
    return blocks * block


def _limits() -> Limits:
    """The card's own, as far as the driver states them."""
    card, usual = cuda.get_current_device(), Limits()
    names = (
        "MAX_THREADS_PER_MULTIPROCESSOR", "MAX_REGISTERS_PER_MULTIPROCESSOR", "MAX_SHARED_MEMORY_PER_MULTIPROCESSOR",
        "MAX_BLOCKS_PER_MULTIPROCESSOR",
    )  # fmt: skip
    return Limits(*(getattr(card, name, known) for name, known in zip(names, usual, strict=True)))


def memory_peak() -> float | None:
    """Bytes per second of the device's memory, from its clock and bus width; None if unknown."""
    card = cuda.get_current_device()
    clock, width = (getattr(card, name, 0) for name in ("MEMORY_CLOCK_RATE", "GLOBAL_MEMORY_BUS_WIDTH"))
    return 2.0 * clock * 1000.0 * width / 8.0 or None
