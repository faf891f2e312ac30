"""Puts work on a stream; raises errors of invalid arguments after each call, or after a block of calls."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np

from ulna.errors import DeviceError, InputError
from ulna.gpu import device
from ulna.gpu.device_array import card, cuda

_FLAGS = 64  # calls between two checks of the flags
Refuse = Callable[[], None]
"""Raises the error of a call's invalid arguments."""


class Queue:
    """The stream of a robot's calls, and the flags that their problems set.

    Attributes:
        is_deferring: Whether calls return without waiting for the device.
    """

    def __init__(self) -> None:
        self._stream, self._card, self.is_deferring, self._unseen = 0, card(), False, []
        self._all, self._each = None, []

    @property
    def stream(self) -> Any:
        """The stream of launches; 0: the default stream. Raises the error of ``refuse_other_card``."""
        self.refuse_other_card()
        return self._stream

    def refuse_other_card(self) -> None:
        """Refuse a call while another card is selected than when the queue was made.

        Raises:
            DeviceError: Numba has selected another card.
        """
        selected = card()
        if selected != self._card:
            remedy = f"call numba.cuda.select_device({self._card}), or on_gpu() again"
            raise DeviceError(f"the robot's tables are on card {self._card}, but Numba has selected card {selected}; {remedy}")

    def marks(self) -> device.Tables:
        """A cleared flag, an int32 on the device, shape (1,): the marks of a launch."""
        if len(self._unseen) == _FLAGS:
            self.look()
        if self._all is None:
            self._all = device.on_device(np.zeros(_FLAGS, dtype=np.int32))
            self._each = [device.Tables((self._all[k : k + 1],)) for k in range(_FLAGS)]
        return self._each[len(self._unseen)]

    @cached_property
    def zeros(self) -> Any:
        """Two zeros, int64 on the device."""
        return device.on_device(np.zeros(2, dtype=np.int64))

    @cached_property
    def spare(self) -> device.Tables:
        """The marks of a launch that nobody reads."""
        return device.Tables((device.on_device(np.zeros(1, dtype=np.int32)),))

    def launched(self, refuse: Refuse, *, is_done: bool = False) -> None:
        """Record a launch with the last flag; read the flag now unless calls are deferred.

        is_done: Whether it has ended already, so that reading the flag does not wait.
        """
        self._unseen.append(refuse)
        if is_done or not self.is_deferring:
            self.look()

    def look(self) -> None:
        """Wait for the launched work, and raise the error of the first call that has one."""
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
        """Within the block, calls do not wait; its end raises errors of invalid arguments. See ``GpuRobot.checked``."""
        if self.is_deferring:
            raise InputError("checked", "calls are deferred already; one block ends before another begins")
        before, self._stream, self.is_deferring = self.stream, self.stream if stream is None else as_stream(stream), True
        try:
            yield
            self.look()
        finally:
            if self._unseen:  # an error ended the block: the next calls need fresh flags
                self._all = None
            self._stream, self.is_deferring, self._unseen = before, False, []


def as_stream(stream: Any) -> Any:
    """A stream of Numba, PyTorch, CuPy, cuda.core, or a stream's number, as launches take it."""
    if hasattr(stream, "auto_synchronize"):
        return stream
    protocol: Any = getattr(stream, "__cuda_stream__", None)
    number: Any = protocol()[1] if protocol is not None else getattr(stream, "cuda_stream", getattr(stream, "ptr", stream))
    if isinstance(number, bool) or not isinstance(number, int | np.integer):
        raise InputError("stream", f"{stream!r}; a CUDA stream, or its number, is expected")
    if not number:
        return 0
    own = cuda.external_stream(int(number))
    own.source = stream  # its library ends a stream that nobody refers to
    return own
