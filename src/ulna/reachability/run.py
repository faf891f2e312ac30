"""Computes what a map still lacks: sizes the tasks, bounds how many are under way.

1. The chunks that are not there wait in their order. The first tasks are one chunk each.
2. Every task returns how long a chunk took; the next ones get so many chunks that they take about ``TASK_S`` of work. Chunks near
   the robot take longer than those beyond its reach, so the estimate follows the last tasks.
3. At most ``UNDER_WAY`` tasks a thread are under way, so that neither the memory of the scheduler nor what is lost at its end
   grows with the map.

Meanwhile no second process can write to the map: the operating system locks a file beside it, and frees it when the process
ends, however it ends.
"""

from __future__ import annotations

import contextlib
import os
import statistics
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from ulna.errors import FileError
from ulna.reachability.chunk import Outcome
from ulna.reachability.grid import Grid
from ulna.reachability.store import undone
from ulna.reachability.workers import Workers

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Around what writes to the map at a path.

    Raises:
        FileError: Another process is writing to it, or the folder cannot be written to.
    """
    beside = path.with_name(f"{path.name}.lock")
    file = _locked_file(beside, path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()  # while it is locked: whoever has opened it sees that it is another file
        os.close(file)


def _locked_file(beside: Path, path: Path) -> int:
    while True:
        try:
            file = os.open(beside, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise FileError(str(path), f"the folder cannot be written to ({error.strerror})") from None
        try:
            _lock(file)
        except OSError:
            os.close(file)
            raise FileError(str(path), "another process is writing to this map; wait for it, or end it") from None
        if _same(file, beside):
            return file
        os.close(file)  # it was removed meanwhile by the process that had it


def _same(file: int, beside: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), beside.stat())
    except OSError:
        return False


def _lock(file: int) -> None:
    """Lock it, or raise an OSError at once if another process has."""
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    import msvcrt  # noqa: PLC0415 -- of Windows alone

    msvcrt.locking(file, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]


TASK_S = 0.7  # of work in a task: 0.5 to 1
UNDER_WAY = 3  # tasks for each that runs
_LAST = 8  # tasks that the estimate looks back on
Tell = Callable[[int, int], object]


class Ran(NamedTuple):
    """What a run has done: chunks computed, tasks, and the seconds inside tasks, of all workers together."""

    chunks: int
    tasks: int
    seconds_inside: float


def run(path: Path, grid: Grid, workers: Workers, tell: Tell | None = None) -> Ran:
    """Compute all chunks that are not there. ``tell`` is called with the poses done so far, and those of the map.

    Raises:
        UlnaError: A task has failed for good, or the cluster is lost. What was computed is kept.
    """
    todo = deque(undone(path, grid))
    total = grid.n_poses
    done = total - sum(_poses(grid, chunk) for chunk in todo)
    seconds: deque[float] = deque(maxlen=_LAST)
    chunks = tasks = under_way = 0
    inside = 0.0
    _tell(tell, done, total)
    try:
        while todo or under_way:
            width = workers.width()
            while todo and under_way < UNDER_WAY * width:
                size = _size(seconds, len(todo), width)
                workers.submit(str(path), tuple(todo.popleft() for _ in range(size)))
                under_way += 1
            for outcome in workers.next_done():
                under_way, tasks = under_way - 1, tasks + 1
                chunks, inside, done = chunks + outcome.chunks, inside + outcome.seconds, done + outcome.poses
                _note(seconds, outcome)
            _tell(tell, done, total)
    finally:
        workers.cancel()
    return Ran(chunks, tasks, inside)


def _size(seconds: deque[float], waiting: int, width: int) -> int:
    """How many chunks the next task gets: one until it is known how long they take, fewer towards the end."""
    if not seconds:
        return 1
    fair = -(-waiting // (2 * width))
    return max(1, min(round(TASK_S / max(statistics.median(seconds), 1e-6)), fair))


def _note(seconds: deque[float], outcome: Outcome) -> None:
    if outcome.seconds_a_chunk > 0.0:
        seconds.append(outcome.seconds_a_chunk)


def _poses(grid: Grid, chunk: int) -> int:
    n = 1
    for cut in grid.region(chunk):
        n *= cut.stop - cut.start
    return n


def _tell(tell: Tell | None, done: int, total: int) -> None:
    if tell is not None:
        tell(done, total)
