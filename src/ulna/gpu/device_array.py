"""Exchanges arrays on a GPU with any library.

Two protocols do that without a copy: ``__cuda_array_interface__`` (CuPy, PyTorch, Numba) and DLPack (these and JAX). numba-cuda
implements the first. The second comes from cuda.core, on which numba-cuda depends. Both are imported late: a robot without a GPU
needs neither.
"""

import importlib
from functools import cache
from importlib.metadata import version
from itertools import accumulate
from math import prod
from operator import mul
from typing import Any

import numpy as np

from ulna.errors import DeviceError, InputError

try:
    import numba.cuda  # of numba_cuda; the module that comes with Numba itself is older
    import numba_cuda  # noqa: F401 # pyright: ignore[reportMissingImports]

    cuda: Any = numba.cuda
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] not in {"numba_cuda", "numba"}:
        raise
    cuda = None
_HOST, _CUDA, _CUDA_HOST, _CUDA_MANAGED = 1, 2, 3, 13  # kinds of devices in DLPack (dlpack.h)
_LEGACY, _PER_THREAD, _NO_ORDER = 1, 2, -1  # streams, as DLPack numbers them


def is_on_device(array: object) -> bool:
    """Whether an array is on an NVIDIA GPU."""
    if getattr(array, "__cuda_ndarray__", False) or hasattr(array, "__cuda_array_interface__"):
        return True
    return _kind(array) in {_CUDA, _CUDA_MANAGED}


def as_own(name: str, array: Any, stream: Any = 0) -> Any:
    """An array on the device as Numba's, without a copy; an array on the host is returned unchanged.

    On the device it has ``__cuda_array_interface__`` or ``__dlpack__``. Work on it, on a stream, follows the work that its
    library has started; the host does not wait. If the interface does not mention a stream, as that of PyTorch, DLPack is used.

    Raises:
        InputError: It is on a device that is neither the host nor an NVIDIA GPU.
        DeviceError: It is on another card than the selected one.
    """
    if getattr(array, "__cuda_ndarray__", False):
        return _ordered(name, array, array, stream)
    interface = getattr(array, "__cuda_array_interface__", None)
    if interface is not None and ("stream" in interface or not hasattr(array, "__dlpack__")):
        return _ordered(name, array, cuda.as_cuda_array(array, sync=False), stream)
    kind = _kind(array)
    if kind not in {_HOST, _CUDA, _CUDA_HOST, _CUDA_MANAGED}:
        raise InputError(name, f"on a device of kind {kind} of DLPack; one on the host or on an NVIDIA GPU is expected")
    if kind not in {_CUDA, _CUDA_MANAGED}:
        return array
    if kind == _CUDA:
        _refuse_other_card(name, int(array.__dlpack_device__()[1]))
    from cuda.core.utils import StridedMemoryView  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    number = number_of(stream)
    asked = _LEGACY if number == _PER_THREAD else number  # both wait for each other, but PyTorch knows only the legacy one
    view = StridedMemoryView.from_dlpack(array, stream_ptr=asked)
    return cuda.from_cuda_array_interface(description(view), owner=view)


def _ordered(name: str, array: Any, own: Any, stream: Any) -> Any:
    """Numba's view of an array, for work on a stream; if the view has no stream, the caller is responsible for the order."""
    _refuse_other_card(name, _card_of(array, own))
    if own.stream:
        order(own.stream, stream)
    return own


def _card_of(array: Any, own: Any) -> int:
    """The number of the card with the memory of an array, of which ``own`` is Numba's view."""
    if cuda.config.ENABLE_CUDASIM or not own.size:
        return card()
    if array is own:
        return own.gpu_data.context.device.id
    if hasattr(array, "__dlpack_device__"):
        kind, number = array.__dlpack_device__()
        return int(number) if kind == _CUDA else card()
    driver, binding = _driver().driver, _driver().binding
    what, pointer = binding.CUpointer_attribute.CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL, own.device_ctypes_pointer.value
    return int(driver.cuPointerGetAttribute(what, binding.CUdeviceptr(pointer)))


def card() -> int:
    """The number of the card that Numba has selected in this thread."""
    return getattr(cuda.get_current_device(), "id", 0)  # the simulator's has none


def _refuse_other_card(name: str, there: int) -> None:
    here = card()
    if there != here:
        raise DeviceError(f"{name} is on card {there}, but Numba has selected card {here}; copy {name} to card {here}")


def order(before: Any, after: Any) -> None:
    """Let later work on a stream wait for the pending work of another one, on the device."""
    if cuda.config.ENABLE_CUDASIM or number_of(before) == number_of(after):
        return
    done = cuda.event(timing=False)
    done.record(before or cuda.default_stream())
    done.wait(after or cuda.default_stream())


def _kind(array: object) -> int:
    """The kind of device of an array, by DLPack; the host if it does not say."""
    place = getattr(array, "__dlpack_device__", None)
    return _HOST if place is None or isinstance(array, np.ndarray) else int(place()[0])


def description(view: Any) -> dict[str, Any]:
    """The ``__cuda_array_interface__`` of a view of cuda.core."""
    dtype = np.dtype(view.dtype)
    strides = view.strides and tuple(stride * dtype.itemsize for stride in view.strides)
    return {
        "shape": tuple(view.shape), "strides": strides, "typestr": dtype.str, "data": (view.ptr, view.readonly), "version": 3,
    }  # fmt: skip


def with_dlpack(array: Any) -> Any:
    """Give Numba's device array in C order ``__dlpack__`` too; the simulator's array is returned unchanged."""
    if cuda.config.ENABLE_CUDASIM:
        return array
    strides = c_strides(array)
    kind = _class_with_dlpack()
    return kind(shape=array.shape, strides=strides, dtype=array.dtype, stream=array.stream, gpu_data=array.gpu_data)


def empty(shape: tuple[int, ...], dtype: Any, stream: Any) -> Any:
    """An uninitialized array on the device, allocated and freed in the order of a stream, without waiting.

    The memory comes from the driver's pool, which CuPy and PyTorch may share. It may be reused for work on the same stream as
    soon as the array is dropped. So work on another stream must have finished, or hold a reference to the array.
    """
    size = prod(shape) * np.dtype(dtype).itemsize
    if cuda.config.ENABLE_CUDASIM or not size:
        return with_dlpack(cuda.device_array(shape, dtype, stream=stream))
    context, kind = cuda.current_context(), np.dtype(dtype)
    buffer = _pool(context.device.id).allocate(size, stream=_core_stream(number_of(stream)))
    pointer = _driver().binding.CUdeviceptr(int(buffer.handle))
    return _as_shaped(_driver().MemoryPointer(context, pointer, size, owner=_PoolMemory(buffer, stream)), shape, kind, stream)


class _PoolMemory:
    """Memory of the pool, and the stream in whose order it is freed: that must exist until then."""

    def __init__(self, buffer: Any, stream: Any) -> None:
        self.buffer, self.stream = buffer, stream

    def __del__(self) -> None:
        self.buffer = None  # before the stream


def idle_memory() -> int:
    """The bytes that the pool of the selected card keeps, but nothing uses."""
    if cuda.config.ENABLE_CUDASIM:
        return 0
    known = _pool(card()).attributes
    return known.reserved_mem_current - known.used_mem_current


def as_shaped(array: Any, shape: tuple[int, ...]) -> Any:
    """Reshape an array in C order without a copy, NumPy's or one on the device.

    Numba's own ``reshape`` takes several times as long, and its result has no stream.
    """
    if isinstance(array, np.ndarray):
        return array.reshape(shape)
    if not hasattr(array, "gpu_data") or not array.size:
        return array.reshape(shape).bind(array.stream)
    return _as_shaped(array.gpu_data, shape, array.dtype, array.stream)


def _as_shaped(pointer: Any, shape: tuple[int, ...], kind: np.dtype, stream: Any) -> Any:
    strides = tuple(accumulate(shape[:0:-1], mul, initial=kind.itemsize))[::-1] if shape else ()
    return _class_with_dlpack()(shape=shape, strides=strides, dtype=kind, stream=stream, gpu_data=pointer)


@cache
def _driver() -> Any:
    return importlib.import_module("numba.cuda.cudadrv.driver")


@cache
def _core_stream(number: int) -> Any:
    from cuda.core import Stream  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    return Stream.from_handle(number)


def number_of(stream: Any) -> int:
    """The handle of a stream as launches take it; 0 is Numba's default stream."""
    return (int(stream) if stream else 0) or (_PER_THREAD if cuda.config.CUDA_PER_THREAD_DEFAULT_STREAM else _LEGACY)


@cache
def _pool(number: int) -> Any:
    """The driver's memory pool of a device, which keeps freed memory."""
    from cuda.core import DeviceMemoryResource  # noqa: PLC0415 # pyright: ignore[reportMissingImports]

    return DeviceMemoryResource(number)


def in_c_order(array: Any) -> Any:
    """Give a contiguous device array of Numba the strides of its shape, without a copy.

    An axis of length 1 may have any stride, but Numba compiles an array with an unusual one for variable strides.
    """
    if array.strides == c_strides(array):
        return array
    return cuda.to_device(array.copy_to_host()) if cuda.config.ENABLE_CUDASIM else with_dlpack(array)


def c_strides(array: Any) -> tuple[int, ...]:
    """The strides of an array's shape in C order, in bytes."""
    sizes = accumulate((max(n, 1) for n in array.shape[:0:-1]), mul, initial=array.dtype.itemsize)
    return tuple(sizes)[: len(array.shape)][::-1]


def refuse_numpy_without_compiler() -> None:
    """Refuse a NumPy with which numba-cuda cannot be imported: up to 0.30.4 it needs a name that NumPy 2.5 lacks.

    Raises:
        DeviceError: numba-cuda cannot be imported with this NumPy.
    """
    try:
        importlib.import_module("numba.cuda.np.arrayobj")
    except AttributeError as error:
        problem = f"numba-cuda {version('numba-cuda')} cannot be used with NumPy {np.__version__} ({error})"
        raise DeviceError(f"{problem}; install an older one: pip install 'numpy<2.5'") from error
    except ModuleNotFoundError:  # the simulator has no compiler
        pass


@cache
def _class_with_dlpack() -> Any:
    from cuda.core.utils import StridedMemoryView  # noqa: PLC0415 # pyright: ignore[reportMissingImports]
    from numba.cuda.cudadrv.devicearray import DeviceNDArray  # noqa: PLC0415

    class DeviceArray(DeviceNDArray):
        """Numba's device array, which other libraries accept by ``__cuda_array_interface__`` or by DLPack."""

        @property
        def __cuda_array_interface__(self) -> dict[str, Any]:
            """Numba's, with a number for the default stream too: without one, other libraries do not wait."""
            return super().__cuda_array_interface__ | {"stream": number_of(self.stream)}

        def reshape(self, *shape: Any, **options: Any) -> Any:
            """Numba's, with the stream."""
            return super().reshape(*shape, **options).bind(self.stream)

        def __dlpack__(self, *, stream: int | None = None, **asked: Any) -> Any:
            """A capsule of DLPack, made by cuda.core. The caller's stream waits for pending work, unless it is -1."""
            if stream != _NO_ORDER:
                order(self.stream, cuda.external_stream(stream or _LEGACY))
            return self._view().__dlpack__(**asked)

        def __dlpack_device__(self) -> tuple[int, int]:
            return self._view().__dlpack_device__()

        def _view(self) -> Any:
            return StridedMemoryView.from_cuda_array_interface(self, stream_ptr=_NO_ORDER)

    return DeviceArray
