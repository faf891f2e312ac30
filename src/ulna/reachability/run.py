"""Computes the missing chunks of a map, by threads of this process or by a Dask cluster.

1. The missing chunks wait in their order. A task gets at most ``_MAX_CHUNKS`` of them, and fewer towards the end.
2. At most ``_MAX_PENDING`` tasks a thread are under way. So the scheduler's memory does not grow with the map, nor does the
   number of results that are lost if the scheduler ends.
3. Threads and cluster are executors of ``concurrent.futures``. Dask's executor repeats a task whose worker has died. It also
   recomputes an outcome that was lost with its worker.

Meanwhile no second process can write to the map. The operating system locks a file beside it, and frees the lock when the process
ends, however it ends.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import threading
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ThreadPoolExecutor, wait
from functools import partial
from pathlib import Path
from typing import Any

from ulna.engine.private_folder import lock_file
from ulna.engine.threads import n_threads, threads
from ulna.errors import ClusterError, FileError, UlnaError, needs_extra
from ulna.reachability.chunk import Outcome, run_on_worker, run_task
from ulna.reachability.grid import Grid
from ulna.reachability.store import missing_chunks

_MAX_CHUNKS = 16  # of a task: a quarter of a second of work for an arm with a closed form, half a second for a search
_MAX_PENDING = 3  # tasks for each thread
_RETRIES = 3
_CHECK_S = 1.0  # between two checks that the cluster is still there
Tell = Callable[[int, int], object]


class Workers:
    """An executor, and the tasks submitted to it; ``ThreadWorkers`` and ``DaskWorkers`` define its width."""

    def __init__(self, pool: Executor, task: Callable[..., Outcome]) -> None:
        self._pool, self._task, self._running = pool, task, set[Future[Outcome]]()

    @property
    def n_pending(self) -> int:
        """The number of tasks submitted and not yet fetched."""
        return len(self._running)

    def width(self) -> int:
        """The number of tasks that run at once."""
        raise NotImplementedError

    def submit(self, path: str, chunks: tuple[int, ...]) -> None:
        """Start a task."""
        self._running.add(self._pool.submit(self._task, path, chunks))

    def next_done(self) -> list[Outcome]:
        """Wait for at least one task to end; the outcomes of all ended tasks."""
        done: set[Future[Outcome]] = set()
        while not done:
            done, self._running = wait(self._running, _CHECK_S, FIRST_COMPLETED)
            if not done:
                self._check_alive()
        return [future.result() for future in done]

    def cancel(self) -> None:
        """Submit nothing more, and wait for the tasks running in this process."""
        raise NotImplementedError

    def _check_alive(self) -> None:
        """Check, during a wait, that results can still arrive."""


class ThreadWorkers(Workers):
    """Threads of this process, each with one task at a time."""

    def __init__(self) -> None:
        self._width, self._stop = n_threads(), threading.Event()
        pool = ThreadPoolExecutor(self._width, thread_name_prefix="ulna-reach", initializer=threads, initargs=(1,))
        super().__init__(pool, partial(run_task, stop=self._stop))

    def width(self) -> int:
        """The number of threads."""
        return self._width

    def cancel(self) -> None:
        """End every task after its current chunk."""
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)


class DaskWorkers(Workers):
    """The workers of a Dask cluster, by its client. A task is repeated if its worker died or failed."""

    def __init__(self, client: Any) -> None:
        with needs_extra("a Dask cluster", "reach", "dask", "distributed"):
            import distributed  # noqa: PLC0415 -- needs the extra
        super().__init__(client.get_executor(pure=False, retries=_RETRIES), run_on_worker)
        self._distributed, self._client, self._warned = distributed, client, False

    def width(self) -> int:
        """The number of threads of all workers, at least 1: workers may still be missing."""
        with self._unified_errors():
            return max(1, sum(self._client.nthreads().values()))

    def submit(self, path: str, chunks: tuple[int, ...]) -> None:
        """Start a task."""
        with self._unified_errors():
            super().submit(path, chunks)

    def next_done(self) -> list[Outcome]:
        """The outcomes of the ended tasks."""
        with self._unified_errors():
            return super().next_done()

    def cancel(self) -> None:
        """Cancel tasks that no worker has begun. Begun tasks end by themselves: a few chunks, with the same bits."""
        with contextlib.suppress(Exception):  # the cluster may be gone
            self._pool.shutdown(wait=False)

    def _check_alive(self) -> None:
        if self._client.status not in ("running", "newly-created"):
            raise ClusterError(f"the connection to the scheduler is lost (it is {self._client.status})")
        if not self._warned and not self._client.nthreads():
            self._warned = True
            words = "the cluster has no worker now; waiting for one (what is computed is kept, and resume=True continues)"
            warnings.warn(words, RuntimeWarning, stacklevel=2)

    @contextlib.contextmanager
    def _unified_errors(self) -> Iterator[None]:
        """Context for calls of Dask: turns its many errors for a lost cluster into one."""
        lost_errors = (CancelledError, asyncio.CancelledError, self._distributed.client.FutureCancelledError)
        try:
            yield
        except UlnaError:
            raise
        except self._distributed.KilledWorker as error:
            raise ClusterError(f"a task has lost its worker again and again, as by too little memory ({error})") from error
        except lost_errors as error:
            raise ClusterError(f"the scheduler or the connection to it is lost ({error or type(error).__name__})") from error
        except OSError as error:
            raise ClusterError(f"the cluster cannot be reached ({error})") from error


def run(path: Path, grid: Grid, workers: Workers, tell: Tell | None = None) -> float:
    """Compute all missing chunks; the time inside tasks [s], summed over all workers.

    ``tell`` is called with the number of poses done and that of the map.
    """
    missing, inside = deque(missing_chunks(path, grid)), 0.0
    done = grid.n_poses - sum(grid.poses_of(chunk) for chunk in missing)
    _tell(tell, done, grid.n_poses)
    try:
        while missing or workers.n_pending:
            width = workers.width()
            while missing and workers.n_pending < _MAX_PENDING * width:
                size = max(1, min(_MAX_CHUNKS, len(missing) // (4 * width)))
                workers.submit(str(path), tuple(missing.popleft() for _ in range(size)))
            for outcome in workers.next_done():
                done, inside = done + outcome.poses, inside + outcome.seconds
            _tell(tell, done, grid.n_poses)
    finally:
        workers.cancel()
    return inside


def _tell(tell: Tell | None, done: int, total: int) -> None:
    if tell is not None:
        tell(done, total)


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Context for writing to the map at a path."""
    lock_path = path.with_name(f"{path.name}.lock")
    file = _locked_file(lock_path, path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            lock_path.unlink()  # while it is locked: a process that has it open sees that it is another file
        os.close(file)


def _locked_file(lock_path: Path, path: Path) -> int:
    while True:
        try:
            file = os.open(lock_path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise FileError(str(path), f"the folder cannot be written to ({error.strerror})") from None
        try:
            lock_file(file)
        except OSError:
            os.close(file)
            raise FileError(str(path), "another process is writing to this map; wait for it, or end it") from None
        with contextlib.suppress(OSError):
            if os.path.samestat(os.fstat(file), lock_path.stat()):
                return file
        os.close(file)  # it was removed meanwhile by the process that held it
