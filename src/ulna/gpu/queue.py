"""Puts work on a stream, and says what was out of range: after each call, or after a block of calls that do not wait."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from ulna.errors import InputError
from ulna.gpu import device
from ulna.gpu.device_array import cuda

_FLAGS = 64  # calls between two looks at what was out of range
Refuse = Callable[[], None]
"""Raises the error that says what of a call's arguments could not be taken."""


class Queue:
    """The stream of a robot's calls, and the flags that their problems set.

    Attributes:
        stream: What launches are given; 0: the default stream.
        is_deferring: Whether calls do not wait for the device.
    """

    def __init__(self) -> None:
        self.stream, self.is_deferring, self._unseen = 0, False, []
        self._all, self._each = None, []

    def marks(self) -> device.Tables:
        """A flag that is not set, an int32 on the device, shape (1,): the marks of a launch."""
        if len(self._unseen) == _FLAGS:
            self.look()
        if self._all is None:
            self._all = device.on_device(np.zeros(_FLAGS, dtype=np.int32))
            self._each = [device.Tables((self._all[k : k + 1],)) for k in range(_FLAGS)]
        return self._each[len(self._unseen)]

    @cached_property
    def spare(self) -> device.Tables:
        """The marks of a launch at which nobody looks."""
        return device.Tables((device.on_device(np.zeros(1, dtype=np.int32)),))

    def launched(self, refuse: Refuse, *, is_done: bool = False) -> None:
        """Note that a call has been launched with the last flag; look at it now unless calls are deferred.

        is_done: Whether it has ended already, so that looking at it waits for nothing.
        """
        self._unseen.append(refuse)
        if is_done or not self.is_deferring:
            self.look()

    def look(self) -> None:
        """Wait for what was launched, and raise the error of the first call that had one."""
        unseen, self._unseen = self._unseen, []
        if not unseen:
            return
        flags = device.on_host(self._all, self.stream)
        if flags.any():
            self._all = None
        for k in np.flatnonzero(flags[: len(unseen)]).tolist():
            unseen[k]()

    @contextmanager
    def checked(self, stream: Any) -> Iterator[None]:
        """Within it calls do not wait; at its end what was out of range is raised. See ``GpuRobot.checked``."""
        if self.is_deferring:
            raise InputError("checked", "calls are deferred already; one block ends before another begins")
        before, self.stream, self.is_deferring = self.stream, self.stream if stream is None else as_stream(stream), True
        try:
            yield
            self.look()
        finally:
            if self._unseen:  # an error ended the block: flags that nobody has looked at are not those of the next calls
                self._all = None
            self.stream, self.is_deferring, self._unseen = before, False, []


def as_stream(stream: Any) -> Any:
    """A stream of Numba, PyTorch, CuPy, cuda.core, or the number of one, as launches take it."""
    if hasattr(stream, "auto_synchronize"):
        return stream
    protocol: Any = getattr(stream, "__cuda_stream__", None)
    number: Any = protocol()[1] if protocol is not None else getattr(stream, "cuda_stream", getattr(stream, "ptr", stream))
    if isinstance(number, bool) or not isinstance(number, int | np.integer):
        raise InputError("stream", f"{stream!r}; a CUDA stream, or its number, is expected")
    return cuda.external_stream(int(number)) if number else 0
