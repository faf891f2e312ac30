"""Runs a page: a thread that makes a frame when something has happened, or after a while. Used by ``view`` and the demo."""

import threading
import traceback
from collections.abc import Callable
from contextlib import suppress


class Loop:
    """Makes frames from ``start`` to ``stop``. One that fails is told, and is no reason for a dead page.

    Args:
        name: Of the thread.
        frame: Makes a frame; called in the thread alone.
        pause: How long to wait for ``wake`` before the next frame [s].

    Attributes:
        stopping: Whether ``stop`` was called.
    """

    def __init__(self, name: str, frame: Callable[[], object], pause: Callable[[], float]) -> None:
        self._frame, self._pause = frame, pause
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
            except Exception:  # noqa: BLE001 - it is told; the next one may do
                traceback.print_exc()
