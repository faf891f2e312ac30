"""Takes rows of arrays on a GPU, and puts others in their places. Used by ``robot.gpu_robot`` and ``robot.gpu_search``.

An array is NumPy's, or on the device: then only the rows that are asked for are copied.
"""

from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.gpu.rows import column, converted, put, taken
from ulna.engine import gpu

Order = NDArray[np.int64]


def rows_of(array: Any, order: Order) -> NDArray[Any]:
    """Some rows of an array (n, ...), on the host."""
    if not gpu.is_on_device(array):
        return array[order]
    flat, out = _as_rows(array), gpu.cuda.device_array((len(order), _width(array)), array.dtype)
    _launch(taken, len(order), flat, gpu.on_device(order), out)
    return out.copy_to_host().reshape(len(order), *array.shape[1:])


def put_rows(array: Any, order: Order, rows: NDArray[Any]) -> None:
    """Write rows of the host to some places of an array (n, m)."""
    if not gpu.is_on_device(array):
        array[order] = rows
        return
    _launch(put, len(order), gpu.on_device(rows), gpu.on_device(order), array)


def column_of(array: Any, k: int) -> NDArray[Any]:
    """A column of an array (n, m), on the host."""
    if not gpu.is_on_device(array):
        return array[:, k]
    out = gpu.cuda.device_array(len(array), array.dtype)
    _launch(column, len(array), array, k, out)
    return out.copy_to_host()


def as_float64(rows: Any) -> Any:
    """Rows of float32 (n, ...) on the device as float64, there."""
    flat = _as_rows(rows)
    wide = gpu.results_for(rows, tuple(flat.shape))
    _launch(converted, len(rows), flat, wide)
    return wide.reshape(*rows.shape)


def _width(array: Any) -> int:
    return prod(array.shape[1:])


def _as_rows(array: Any) -> Any:
    return array.reshape(len(array), _width(array))


def _launch(driver: Any, n: int, *arguments: Any) -> None:
    if n:
        gpu.compiled(driver)[gpu.blocks(n), gpu.THREADS](*arguments)
