"""Runs tasks side by side: on a thread pool, or on a Dask cluster."""

from __future__ import annotations

import asyncio
import threading
import warnings
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from queue import Empty, Queue
from typing import Any, Protocol

from ulna.errors import ClusterError, UlnaError, needs_extra
from ulna.reachability.chunk import Outcome, run_task

_RETRIES = 3
_LOOK_S = 1.0  # between two looks at whether the cluster is still there


class Workers(Protocol):
    """What runs tasks. Used as a context: at its end nothing that it started goes on writing here."""

    def width(self) -> int:
        """How many tasks run at once."""
        ...

    def submit(self, path: str, chunks: tuple[int, ...]) -> None:
        """Start a task."""
        ...

    def next_done(self) -> list[Outcome]:
        """Wait for at least one task to end, and return what has ended.

        Raises:
            UlnaError: A task has failed for good.
        """
        ...

    def cancel(self) -> None:
        """Start nothing more, and wait for what is running here."""
        ...


class ThreadWorkers:
    """A pool of threads in this process, one task a thread."""

    def __init__(self, threads: int) -> None:
        self._threads, self._stop = threads, threading.Event()
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="ulna-reach")
        self._running: set[Future[Outcome]] = set()

    def width(self) -> int:
        """The number of threads."""
        return self._threads

    def submit(self, path: str, chunks: tuple[int, ...]) -> None:
        """Start a task."""
        self._running.add(self._pool.submit(run_task, path, chunks, 1, self._stop))

    def next_done(self) -> list[Outcome]:
        """The outcomes of the tasks that have ended."""
        done, self._running = wait(self._running, return_when=FIRST_COMPLETED)
        return [future.result() for future in done]

    def cancel(self) -> None:
        """End every task after the chunk that it computes."""
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)


class DaskWorkers:
    """The workers of a Dask cluster, by its client. A task is tried again where a worker has died or failed."""

    def __init__(self, client: Any) -> None:
        with needs_extra("a Dask cluster", "reach", "dask", "distributed"):
            import distributed  # noqa: PLC0415 -- needs the extra
        self._distributed, self._client = distributed, client
        self._running: set[Any] = set()
        self._warned = False
        self._ended: Queue[Any] = Queue()

    def width(self) -> int:
        """The number of threads of all workers, at least 1: there may be none yet."""
        with _clearly(self._distributed):
            return max(1, sum(self._client.nthreads().values()))

    def submit(self, path: str, chunks: tuple[int, ...]) -> None:
        """Start a task."""
        with _clearly(self._distributed):
            future = self._client.submit(run_task, path, chunks, pure=False, retries=_RETRIES)
            self._running.add(future)
            future.add_done_callback(self._ended.put)

    def next_done(self) -> list[Outcome]:
        """The outcomes of the tasks that have ended; their futures are released.

        An outcome is lost with the worker that holds it. Dask then computes the task again, and this waits for it.
        """
        ended = [self._first_ended()]
        while not self._ended.empty():
            ended.append(self._ended.get())
        outcomes = [self._outcome(future) for future in ended]
        self._running.difference_update(ended)
        return outcomes

    def _first_ended(self) -> Any:
        while True:
            try:
                return self._ended.get(timeout=_LOOK_S)
            except Empty:
                self._look()

    def _outcome(self, future: Any) -> Outcome:
        while True:
            try:
                with _clearly(self._distributed):
                    return future.result(timeout=_LOOK_S)
            except ClusterError as error:
                if future.status == "error" or not isinstance(error.__cause__, TimeoutError | asyncio.TimeoutError):
                    raise  # not of the waiting: of the task, or of the cluster
                self._look()

    def _look(self) -> None:
        """See, while nothing comes, whether something still can."""
        self._refuse_lost()
        self._warn_of_no_workers()

    def cancel(self) -> None:
        """Take back what no worker has begun; what one has begun it ends: a few chunks, of the same bits."""
        with suppress(Exception):  # the cluster may be gone
            self._client.cancel(list(self._running), force=True)
        self._running.clear()

    def _refuse_lost(self) -> None:
        if self._client.status not in ("running", "newly-created"):
            raise ClusterError(f"the connection to the scheduler is lost (it is {self._client.status})")

    def _warn_of_no_workers(self) -> None:
        with _clearly(self._distributed):
            if not self._warned and not self._client.nthreads():
                self._warned = True
                words = "the cluster has no worker now; waiting for one (what is computed is kept, and resume=True continues)"
                warnings.warn(words, RuntimeWarning, stacklevel=2)


@contextmanager
def _clearly(distributed: Any) -> Iterator[None]:
    """Around calls of Dask: its many ways to say that the cluster is gone become one error."""
    lost = (CancelledError, asyncio.CancelledError, distributed.client.FutureCancelledError)
    try:
        yield
    except UlnaError:
        raise
    except distributed.KilledWorker as error:
        raise ClusterError(f"a task has lost its worker again and again, as by too little memory ({error})") from error
    except lost as error:
        raise ClusterError(f"the scheduler or the connection to it is lost ({error or type(error).__name__})") from error
    except (OSError, TimeoutError) as error:
        raise ClusterError(f"the cluster cannot be reached ({error})") from error
