"""Starts programs that end together with this one."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import AbstractContextManager
from typing import NamedTuple

from ulna.errors import MissingROSError

_END_WITHIN_S = 5.0
_FAULTS = ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL")
_CRASHES = tuple(getattr(signal, name) for name in _FAULTS if hasattr(signal, name))  # Windows has no SIGBUS


class Ended(NamedTuple):
    """A program that has ended by itself: its name and its status, which is negative if a signal ended it."""

    name: str
    status: int

    @property
    def crashed(self) -> bool:
        """Whether a fault ended it."""
        return -self.status in _CRASHES

    def __str__(self) -> str:
        return f"{self.name} has {'crashed' if self.crashed else 'ended'} (status {self.status})"


class Children(AbstractContextManager):
    """Started programs, by name. At the end of the ``with`` block they are ended, the last first."""

    def __init__(self) -> None:
        self._running: dict[str, subprocess.Popen] = {}

    def start(self, name: str, *command: str, quiet: bool = False, pass_fds: tuple[int, ...] = ()) -> None:
        """Start a program without output, with ``quiet`` without errors too. Ctrl-C in a terminal does not reach it."""
        nothing = subprocess.DEVNULL
        try:
            child = subprocess.Popen(  # noqa: S603
                command,
                stdin=nothing,
                stdout=nothing,
                stderr=nothing if quiet else None,
                start_new_session=True,
                pass_fds=pass_fds,
            )
        except FileNotFoundError:
            raise MissingROSError(f"the program {command[0]!r} is not installed; docs/ros.md explains its installation") from None
        self._running[name] = child

    def ended(self) -> Iterator[Ended]:
        """The programs that have ended by themselves since the last call."""
        for name, child in list(self._running.items()):
            if child.poll() is not None:
                del self._running[name]
                yield Ended(name, child.returncode)

    def end(self, name: str) -> None:
        """End a program with SIGTERM, or with SIGKILL if it does not end in time."""
        child = self._running.pop(name, None)
        if child is None:
            return
        child.send_signal(signal.SIGTERM)
        try:
            child.wait(_END_WITHIN_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()

    def end_all(self) -> None:
        """End every program, the last first."""
        for name in reversed(list(self._running)):
            self.end(name)

    def __exit__(self, *_: object) -> None:
        self.end_all()
