"""Runs a page: a thread that makes a frame when something has happened, or after a while. Used by ``view`` and the demo."""

import threading
import traceback
from collections.abc import Callable
from contextlib import suppress


class Loop:
    """Makes frames from ``start`` to ``stop``. One that fails is logged, and is no reason for a dead page.

    Args:
        name: Of the thread.
        frame: Makes a frame; called in the thread alone.
        pause: How long to wait for ``wake`` before the next frame [s].
        failed: Called when a frame fails, with the error, and with None when one succeeds after that.

    Attributes:
        stopping: Whether ``stop`` was called.
    """

    def __init__(
        self,
        name: str,
        frame: Callable[[], object],
        pause: Callable[[], float],
        failed: Callable[[Exception | None], object] = lambda _: None,
    ) -> None:
        self._frame, self._pause, self._failed = frame, pause, failed
        self._failure = ""
        self._wake, self.stopping = threading.Event(), False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def wake(self) -> None:
        """Something has happened: the next frame is made at once."""
        self._wake.set()

    @property
    def ended(self) -> bool:
        """Whether the last frame has ended."""
        return not self._thread.is_alive()

    def stop(self, within: float) -> None:
        """Make no more frames, and wait for the last one, so many seconds at most."""
        self.stopping = True
        self._wake.set()
        self._thread.join(timeout=within)

    def wait(self) -> None:
        """Wait until it is stopped, or for Ctrl-C."""
        with suppress(KeyboardInterrupt):
            while not self.ended:
                self._thread.join(timeout=0.5)

    def _run(self) -> None:
        while not self.stopping:
            self._wake.wait(self._pause())
            self._wake.clear()
            try:
                self._frame()
            except Exception as error:  # noqa: BLE001 - it is logged and shown; the next frame may succeed
                self._note(error)
            else:
                if self._failure:
                    self._note(None)

    def _note(self, error: Exception | None) -> None:
        """Log a failure, once as long as it stays the same, and pass it on."""
        failure = "" if error is None else f"{type(error).__name__}: {error}"
        if failure and failure != self._failure:
            traceback.print_exception(error)
        self._failure = failure
        with suppress(Exception):  # the page that cannot show it may be what has failed
            self._failed(error)
