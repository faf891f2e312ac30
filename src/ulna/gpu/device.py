"""Compiles drivers for a GPU and runs them over batches, by numba-cuda.

The extra ``cuda12`` or ``cuda13``, a GPU and its driver are needed only where something is run. With
``NUMBA_ENABLE_CUDASIM=1`` and ``NUMBA_DISABLE_JIT=1`` threads are simulated in plain Python, for tests.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import DeviceError, InputError, MissingExtraError
from ulna.gpu.device_array import cuda, in_c_order, is_on_device, refuse_numpy_without_compiler, with_dlpack

THREADS = 128  # of a block
PIECE = 1 << 17  # problems that are copied and computed together where arrays are on the host
Rows = Any
"""An array whose first axis is the batch: NumPy's, or one on the device (``device_array``)."""


def require_device() -> None:
    """Refuse to go on without a GPU."""
    if cuda is None:
        raise MissingExtraError("a GPU with a driver of CUDA 13 (cuda12 for one of CUDA 12)", "cuda13")
    refuse_numpy_without_compiler()
    if not cuda.is_available():
        raise DeviceError("no NVIDIA GPU was found, or its driver is not installed")


def on_device(array: NDArray) -> Any:
    """A copy of an array on the device, with the strides of its shape.

    ``np.ascontiguousarray`` keeps an axis of length 1 whose stride is 0 (``x[None]``), which Numba takes for no C order.
    """
    return with_dlpack(cuda.to_device(np.array(array, order="C")))


def as_device_rows(name: str, own: Any, shape: tuple[int, ...], dtype: Any = np.float64) -> Any:
    """Numba's array on the device as rows of a shape, not copied: shape (n, *shape). Any leading axes count as one."""
    tail = own.shape[len(own.shape) - len(shape) :] if len(own.shape) >= len(shape) else ()
    if own.dtype != dtype or tail != shape:
        expected = f"{np.dtype(dtype)} of shape (..., {_listed(shape)}) is expected"
        raise InputError(name, f"{own.dtype} of shape {tuple(own.shape)} on the device; {expected}")
    if not own.is_c_contiguous():
        raise InputError(name, "an array on the device has to be C-contiguous")
    return in_c_order(own.reshape(int(np.prod(own.shape[: len(own.shape) - len(shape)], dtype=np.int64)), *shape))


@cache
def compiled(driver: Callable) -> Any:
    """A driver as what runs on the device, compiled for it when it is first run."""
    return cuda.jit(driver)


def run(
    driver: Any,
    constants: Sequence[Any],
    batch: Rows,
    results: Sequence[Any],
    flag: Any,
    *,
    shares_scratch: bool = False,
    threads_each: int = 1,
) -> None:
    """Run a driver, a problem a thread: ``driver(*constants, batch, *results, flag)``.

    Args:
        driver: Of ``compiled``.
        constants: What all problems share, on the device, and numbers.
        batch: Shape (n, ...). Where it is NumPy's, it is copied piece by piece, while other pieces are computed.
        results: Arrays with n rows each, where the batch is.
        flag: An int32 on the device, shape (1,), which problems set.
        shares_scratch: Whether scratch is among the constants: then one piece is computed at a time.
        threads_each: How many threads a problem has, beside each other.
    """
    if not len(batch):
        return
    if is_on_device(batch):
        driver[blocks(threads_each * len(batch)), THREADS](*constants, batch, *results, flag)
        return
    n = len(batch)
    places = [_Place((batch, *results)) for _ in range(1 if shares_scratch or n <= PIECE else 2)]
    for k, start in enumerate(range(0, n, PIECE)):
        place, part = places[k % len(places)], slice(start, min(start + PIECE, n))
        place.finish()
        there, *own = place.fill(part)
        driver[blocks(threads_each * len(there)), THREADS, place.stream](*constants, there, *own, flag)
        place.fetch()
    for place in places:
        place.finish()


class _Place:
    """A stream, and room on the device for a piece of a batch and of its results: used again for every other piece.

    Where there are several pieces, a copy goes through memory that the device reads by itself (pinned): else it would wait for
    the work before it. The caller's own arrays are not pinned: that takes as long as a copy, and read-only ones cannot be.
    """

    def __init__(self, arrays: Sequence[NDArray[Any]]) -> None:
        self._arrays, self._part = arrays, slice(0, 0)
        self.stream, rows = cuda.stream(), min(len(arrays[0]), PIECE)
        shapes = [((rows, *each.shape[1:]), each.dtype) for each in arrays]
        self._there = [cuda.device_array(*shape) for shape in shapes]
        self._staged = [cuda.pinned_array(*shape) for shape in shapes] if len(arrays[0]) > PIECE else None

    def fill(self, part: slice) -> list[Any]:
        """Begin to copy a part of the batch to the device; the places there of it and of its results."""
        self._part, n, source = part, part.stop - part.start, self._arrays[0][part]
        if self._staged is not None:
            np.copyto(self._staged[0][:n], source)
            source = self._staged[0][:n]
        there = [each[:n] for each in self._there]
        there[0].copy_to_device(source, stream=self.stream)
        return there

    def fetch(self) -> None:
        """Begin to copy the results back."""
        n = self._part.stop - self._part.start
        for k in range(1, len(self._arrays)):
            target = self._arrays[k][self._part] if self._staged is None else self._staged[k][:n]
            self._there[k][:n].copy_to_host(target, stream=self.stream)

    def finish(self) -> None:
        """Wait for the last part, and write its results to their arrays."""
        self.stream.synchronize()
        n = self._part.stop - self._part.start
        for result, staged in zip(self._arrays[1:], (self._staged or ())[1:], strict=False):
            result[self._part] = staged[:n]
        self._part = slice(0, 0)


def blocks(n: int) -> int:
    """How many blocks n threads need."""
    return -(-n // THREADS)


def results_for(batch: Rows, shape: tuple[int, ...], dtype: Any = np.float64) -> Any:
    """An uninitialised array of a shape where a batch is: on the device, or NumPy's."""
    if not is_on_device(batch):
        return np.empty(shape, dtype)
    return with_dlpack(cuda.device_array(shape, dtype))


def free_memory() -> float:
    """The device's free memory, in bytes; infinite where it is simulated."""
    return cuda.current_context().get_memory_info()[0]


def _listed(shape: tuple[int, ...]) -> str:
    return ", ".join(map(str, shape))
