"""Compiles drivers for a GPU and runs them over batches, by numba-cuda. Used by ``drivers.gpu`` and ``robot.gpu_robot``.

The extra ``cuda``, a GPU and its driver are needed only where something is run. With
``NUMBA_ENABLE_CUDASIM=1`` and ``NUMBA_DISABLE_JIT=1`` threads are simulated in plain Python, for tests.
"""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.errors import DeviceError, InputError, MissingExtraError

try:
    import numba.cuda  # of numba_cuda; the one that comes with Numba itself is older
    import numba_cuda  # noqa: F401 # pyright: ignore[reportMissingImports]

    cuda: Any = numba.cuda
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] not in {"numba_cuda", "numba"}:
        raise
    cuda = None
THREADS = 128  # of a block
PIECE = 1 << 17  # problems that are copied and computed together where arrays are on the host
Rows = Any
"""An array whose first axis is the batch: NumPy's, or one on the device that has ``__cuda_array_interface__``."""


def require_device() -> None:
    """Refuse to go on without a GPU.

    Raises:
        DeviceError: There is no GPU, or no driver for it.
        MissingExtraError: The extra ``cuda`` is not installed.
    """
    if cuda is None:
        raise MissingExtraError("a GPU", "cuda")
    if not cuda.is_available():
        raise DeviceError("no NVIDIA GPU was found, or its driver is not installed")


def on_device(array: NDArray) -> Any:
    """A copy of an array on the device."""
    return cuda.to_device(np.ascontiguousarray(array))


def is_on_device(array: object) -> bool:
    """Whether an array is on a device."""
    return hasattr(array, "__cuda_array_interface__")


def as_device_rows(name: str, array: Any, shape: tuple[int, ...]) -> Any:
    """A device array as rows of a shape, not copied: shape (n, *shape). Any leading axes count as one.

    Raises:
        InputError: It is not float64, of another shape, or not C-contiguous.
    """
    own = cuda.as_cuda_array(array)
    tail = own.shape[len(own.shape) - len(shape) :] if len(own.shape) >= len(shape) else ()
    if own.dtype != np.float64 or tail != shape:
        raise InputError(
            name, f"{own.dtype} of shape {own.shape} on the device; float64 of shape (..., {_listed(shape)}) is expected"
        )
    if not own.is_c_contiguous():
        raise InputError(name, "an array on the device has to be C-contiguous")
    return own.reshape(int(np.prod(own.shape[: len(own.shape) - len(shape)], dtype=np.int64)), *shape)


def compiled(driver: Callable) -> Any:
    """A driver as what runs on the device, compiled for it when it is first run."""
    return _compiled(driver)


@cache
def _compiled(driver: Callable) -> Any:
    return cuda.jit(driver)


def run(
    driver: Any, constants: Sequence[Any], batch: Rows, results: Sequence[Any], flag: Any, *, shares_scratch: bool = False
) -> None:
    """Run a driver, a problem a thread: ``driver(*constants, batch, *results, flag)``.

    Args:
        driver: Of ``compiled``.
        constants: What all problems share, on the device, and numbers.
        batch: Shape (n, ...). Where it is NumPy's, it is copied piece by piece, while other pieces are computed.
        results: Arrays with n rows each, where the batch is.
        flag: An int32 on the device, shape (1,), which problems set.
        shares_scratch: Whether scratch is among the constants: then one piece is computed at a time.
    """
    if is_on_device(batch):
        if len(batch):
            driver[blocks(len(batch)), THREADS](*constants, batch, *results, flag)
        return
    streams = [cuda.stream() for _ in range(1 if shares_scratch else 2)]
    with ExitStack() as stack:
        for array in (batch, *results):
            stack.enter_context(cuda.pinned(array))
        for k, start in enumerate(range(0, len(batch), PIECE)):
            stream, part = streams[k % len(streams)], slice(start, start + PIECE)
            there = cuda.to_device(batch[part], stream=stream)
            own = [cuda.device_array(result[part].shape, result.dtype, stream=stream) for result in results]
            driver[blocks(len(batch[part])), THREADS, stream](*constants, there, *own, flag)
            for result, on_gpu in zip(results, own, strict=True):
                on_gpu.copy_to_host(result[part], stream=stream)
        for stream in streams:
            stream.synchronize()


def blocks(n: int) -> int:
    """How many blocks n threads need."""
    return -(-n // THREADS)


def results_for(batch: Rows, shape: tuple[int, ...], dtype: Any = np.float64) -> Any:
    """An uninitialised array of a shape where a batch is: on the device, or NumPy's."""
    return cuda.device_array(shape, dtype) if is_on_device(batch) else np.empty(shape, dtype)


def free_memory() -> float:
    """The device's free memory, in bytes; infinite where it is simulated."""
    return cuda.current_context().get_memory_info()[0]


def _listed(shape: tuple[int, ...]) -> str:
    return ", ".join(map(str, shape))
