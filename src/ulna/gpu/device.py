"""Compiles drivers for a GPU and runs them over batches, by numba-cuda.

The extra ``cuda12`` or ``cuda13``, a GPU and its driver are needed only to run something. With ``NUMBA_ENABLE_CUDASIM=1`` and
``NUMBA_DISABLE_JIT=1`` threads are simulated in plain Python, for tests.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import DeviceError, InputError, MissingExtraError
from ulna.gpu.device_array import (
    as_shaped,
    c_strides,
    cuda,
    empty,
    idle_memory,
    in_c_order,
    is_on_device,
    order,
    refuse_numpy_without_compiler,
    with_dlpack,
)

THREADS = 128  # of a block
PIECE = 1 << 17  # problems that are copied and computed together if arrays are on the host
Rows = Any
"""An array whose first axis is the batch: NumPy's, or one on the device (``device_array``)."""


def require_device() -> None:
    """Raise an error if there is no GPU."""
    if cuda is None:
        raise MissingExtraError("a GPU with a driver of CUDA 13 (cuda12 for one of CUDA 12)", "cuda13")
    refuse_numpy_without_compiler()
    if not cuda.is_available():
        raise DeviceError("no NVIDIA GPU was found, or its driver is not installed")


def on_device(array: Any, stream: Any = None) -> Any:
    """A copy of an array on the device, with the strides of its shape.

    With a stream (0: the default stream) the copy is for work on this stream, and nothing waits. Without one it is finished when
    the call returns, so work on any stream may read it.
    """
    # np.ascontiguousarray keeps a stride of 0 for an axis of length 1 (x[None]), which Numba does not accept as C order.
    array = np.array(array, order="C")
    if stream is None:
        there = with_dlpack(cuda.to_device(array))
        cuda.default_stream().synchronize()  # the driver may return from a copy before its end
        return there
    return copied(array, stream)


def copied(array: Any, stream: Any) -> Any:
    """A copy on the device, for work on a stream, of an array in C order; nothing waits."""
    there = empty(tuple(array.shape), array.dtype, stream)
    there.copy_to_device(array, stream=stream or cuda.default_stream())  # with 0 it would wait
    return there


def as_device_rows(name: str, own: Any, shape: tuple[int, ...], dtype: Any = np.float64) -> Any:
    """View Numba's array on the device as rows, shape (n, *shape), without a copy; leading axes are merged."""
    tail = own.shape[len(own.shape) - len(shape) :] if len(own.shape) >= len(shape) else ()
    if own.dtype != dtype or tail != shape:
        expected = f"{np.dtype(dtype)} of shape (..., {_listed(shape)}) is expected"
        raise InputError(name, f"{own.dtype} of shape {tuple(own.shape)} on the device; {expected}")
    if len(own.shape) == len(shape) + 1 and own.strides == c_strides(own):
        return own
    if not own.is_c_contiguous():
        raise InputError(name, "an array on the device has to be C-contiguous")
    return in_c_order(as_shaped(own, (int(np.prod(own.shape[: len(own.shape) - len(shape)], dtype=np.int64)), *shape)))


class Tables:
    """Arrays on the device and numbers for repeated launches, as a tuple whose type is determined once."""

    def __init__(self, parts: Iterable[Any]) -> None:
        self._parts = tuple(parts)

    def __getitem__(self, k: int) -> Any:
        return self._parts[k]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    @cached_property
    def _numba_type_(self) -> Any:  # Numba reads it
        from numba.core import types  # noqa: PLC0415
        from numba.cuda.typing.typeof import Purpose, typeof  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

        return types.Tuple([typeof(part, Purpose.argument) for part in self._parts])


class Launch(NamedTuple):
    """The launch of a driver.

    Attributes:
        each: The number of threads per row.
        at_most: The maximum number of threads; each has its own scratch among the tables.
        stream: The stream for a batch on the device, and the one that has the tables for any batch; 0: the default stream.
    """

    each: int = 1
    at_most: int = 1 << 40
    stream: Any = 0


LAUNCH = Launch()


@cache
def compiled(driver: Callable) -> Any:
    """A driver for the device; compiled at its first run."""
    return cuda.jit(driver)


def run(driver: Any, tables: Iterable[Any], batch: Rows, results: Sequence[Any], marks: Any, launch: Launch = LAUNCH) -> None:
    """Run a driver of ``staged.over_rows``: ``driver(tables, batch, results[0], (*marks, *results[1:]))``.

    Args:
        driver: The plain function; it is compiled at its first run.
        tables: Data that all problems share, on the device, and numbers.
        batch: Shape (n, m). NumPy's array is copied in pieces, while other pieces are computed.
        results: Arrays with a row for each problem, on the side of the batch.
        marks: A flag that problems set, an int32 on the device, shape (1,).
        launch: Threads and stream.
    """
    if not len(batch):
        return
    runs, threads = compiled(driver), driver.threads
    at_most = max(1, launch.at_most // threads)
    if is_on_device(batch):
        grid = min(at_most, -(-launch.each * len(batch) // threads)), threads, launch.stream
        runs[grid](tables, batch, results[0], marks if len(results) == 1 else (*marks, *results[1:]))
        for each in results:
            if each.stream:  # the caller's array may name another one
                order(launch.stream, each.stream)
        return
    n = len(batch)
    n_places = 1 if launch.at_most < LAUNCH.at_most or n <= PIECE else 2
    places = [_Place((batch, *results), launch.stream) for _ in range(n_places)]
    for k, start in enumerate(range(0, n, PIECE)):
        place, part = places[k % len(places)], slice(start, min(start + PIECE, n))
        place.finish()
        there, *own = place.fill(part)
        grid = min(at_most, -(-launch.each * len(there) // threads))
        runs[grid, threads, place.stream](tables, there, own[0], (*marks, *own[1:]))
        place.fetch()
    for place in places:
        place.finish()


class _Place:
    """A stream, and device memory for a piece of a batch and its results, reused for every other piece.

    With several pieces, a copy goes through pinned memory, which the device reads itself; otherwise it would wait for earlier
    work. The caller's own arrays are not pinned: that takes as long as a copy, and read-only ones cannot be.
    """

    def __init__(self, arrays: Sequence[NDArray[Any]], before: Any) -> None:
        """before: the stream whose work comes first."""
        self._arrays, self._part, n = arrays, slice(0, 0), len(arrays[0])
        self._each = [len(array) // n for array in arrays]  # rows per problem
        self.stream, rows = cuda.stream(), min(n, PIECE)
        order(before, self.stream)
        shapes = [((k * rows, *array.shape[1:]), array.dtype) for k, array in zip(self._each, arrays, strict=True)]
        self._there = [cuda.device_array(*shape) for shape in shapes]
        self._staged = [cuda.pinned_array(*shape) for shape in shapes] if n > PIECE else None

    def _part_of(self, k: int) -> tuple[int, slice]:
        """The number of rows of array k in the part, and these rows."""
        each = self._each[k]
        return each * (self._part.stop - self._part.start), slice(each * self._part.start, each * self._part.stop)

    def fill(self, part: slice) -> list[Any]:
        """Start to copy a part of the batch to the device; returns the device arrays for batch and results."""
        self._part, n, source = part, part.stop - part.start, self._arrays[0][part]
        if self._staged is not None:
            np.copyto(self._staged[0][:n], source)
            source = self._staged[0][:n]
        there = [array[: self._part_of(k)[0]] for k, array in enumerate(self._there)]
        there[0].copy_to_device(source, stream=self.stream)
        return there

    def fetch(self) -> None:
        """Start to copy the results back."""
        for k in range(1, len(self._arrays)):
            n, part = self._part_of(k)
            target = self._arrays[k][part] if self._staged is None else self._staged[k][:n]
            self._there[k][:n].copy_to_host(target, stream=self.stream)

    def finish(self) -> None:
        """Wait for the last part, and write its results to their arrays."""
        self.stream.synchronize()
        for k in range(1, len(self._arrays) if self._staged else 0):
            n, part = self._part_of(k)
            self._arrays[k][part] = self._staged[k][:n]  # pyright: ignore[reportOptionalSubscript]
        self._part = slice(0, 0)


def blocks(n: int) -> int:
    """The number of blocks for n threads."""
    return -(-n // THREADS)


def results_for(batch: Rows, shape: tuple[int, ...], dtype: Any, stream: Any) -> Any:
    """An uninitialized array of a shape on the side of a batch: on the device, or NumPy's."""
    return empty(shape, dtype, stream) if is_on_device(batch) else np.empty(shape, dtype)


def on_host(array: Any, stream: Any = 0) -> NDArray[Any]:
    """Copy an array from the device, after the work on a stream, by default its own; NumPy's is returned unchanged."""
    if not is_on_device(array):
        return array
    stream = stream or array.stream
    out = array.copy_to_host(stream=stream)
    if stream:
        stream.synchronize()
    return out


def free_memory(needed: float = 0.0) -> float:
    """The device's free memory and what the pool keeps unused, in bytes; infinite in the simulator.

    If that is less than needed, memory that Numba would free later is freed first.
    """
    context = cuda.current_context()
    free = context.get_memory_info()[0] + idle_memory()
    if free < needed:
        context.deallocations.clear()
        free = context.get_memory_info()[0] + idle_memory()
    return free


def _listed(shape: tuple[int, ...]) -> str:
    return ", ".join(map(str, shape))
