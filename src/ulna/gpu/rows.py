"""Takes rows of arrays on a GPU, converts them, and puts others in their places.

An array is NumPy's, or on the device: then only the rows that are asked for are copied.
"""

from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.gpu import device
from ulna.gpu.device import cuda

Order = NDArray[np.int64]


def rows_of(array: Any, order: Order) -> NDArray[Any]:
    """Some rows of an array (n, ...), on the host."""
    if not device.is_on_device(array):
        return array[order]
    flat, out = _as_rows(array), cuda.device_array((len(order), _width(array)), array.dtype)
    _launch(taken, len(order), flat, device.on_device(order), out)
    return out.copy_to_host().reshape(len(order), *array.shape[1:])


def put_rows(array: Any, order: Order, rows: NDArray[Any]) -> None:
    """Write rows of the host to some places of an array (n, m)."""
    if not device.is_on_device(array):
        array[order] = rows
        return
    _launch(put, len(order), device.on_device(rows), device.on_device(order), array)


def put_records(array: Any, order: Order, records: NDArray[Any]) -> None:
    """Write records of the host to some places of an array of them (n,)."""
    if not device.is_on_device(array):
        array[order] = records
        return
    _launch(put_each, len(order), device.on_device(records), device.on_device(order), array)


def as_float64(rows: Any) -> Any:
    """Rows of float32 (n, ...) on the device as float64, there."""
    flat = _as_rows(rows)
    wide = device.results_for(rows, tuple(flat.shape))
    _launch(converted, len(rows), flat, wide)
    return wide.reshape(*rows.shape)


def _width(array: Any) -> int:
    return prod(array.shape[1:])


def _as_rows(array: Any) -> Any:
    return array.reshape(len(array), _width(array))


def _launch(driver: Any, n: int, *arguments: Any) -> None:
    if n:
        device.compiled(driver)[device.blocks(n), device.THREADS](*arguments)


# ---- what a thread does, a row each ----------------------------------------------------------------------


def converted(rows, out):
    """Write rows, shape (n, m), to out, of the same shape and of numbers of another size."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]


def taken(rows, order, out):
    """Write the rows (n, m) that an order (k,) names to out (k, m)."""
    i = cuda.grid(1)
    if i < out.shape[0]:
        for k in range(out.shape[1]):
            out[i, k] = rows[order[i], k]


def put(rows, order, out):
    """Write rows (k, m) to the rows of out (n, m) that an order (k,) names."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[order[i], k] = rows[i, k]


def put_each(records, order, out):
    """Write records (k,) to the places of out (n,) that an order (k,) names."""
    i = cuda.grid(1)
    if i < records.shape[0]:
        out[order[i]] = records[i]
