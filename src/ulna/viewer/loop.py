"""Runs the thread that draws the frames of a page, after each event and at intervals."""

import threading
import traceback
from collections.abc import Callable
from contextlib import suppress


class Loop:
    """Draws frames from ``start`` to ``stop``. After a frame that fails, the error is logged and the loop continues.

    Args:
        name: The name of the thread.
        frame: Draws a frame; only this thread calls it.
        pause: Returns the maximum time to wait for ``wake`` before the next frame [s].
        on_failure: Called with the error when a frame fails, and with None when the next one succeeds.

    Attributes:
        stopping: Whether ``stop`` was called.
    """

    def __init__(
        self,
        name: str,
        frame: Callable[[], object],
        pause: Callable[[], float],
        on_failure: Callable[[Exception | None], object] = lambda _: None,
    ) -> None:
        self._frame, self._pause, self._on_failure = frame, pause, on_failure
        self._failure = ""
        self._wake, self.stopping = threading.Event(), False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def wake(self) -> None:
        """Draw the next frame at once."""
        self._wake.set()

    @property
    def ended(self) -> bool:
        """Whether the last frame has ended."""
        return not self._thread.is_alive()

    def stop(self, within: float) -> None:
        """Draw no more frames, and wait at most ``within`` seconds for the last one."""
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
        """Log a failure, unless it is the same as the last one, and call ``on_failure``."""
        failure = "" if error is None else f"{type(error).__name__}: {error}"
        if failure and failure != self._failure:
            traceback.print_exception(error)
        self._failure = failure
        with suppress(Exception):  # showing it on the page may fail too
            self._on_failure(error)
