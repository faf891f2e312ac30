"""Converts arrays of float32 to float64 on a GPU.

A robot with ``float32`` takes such arrays, and converts them for the methods that compute in float64.
"""

from math import prod
from typing import Any

from ulna.gpu import device
from ulna.gpu.device import cuda
from ulna.gpu.device_array import as_shaped


def as_float64(rows: Any, stream: Any) -> Any:
    """Convert rows of float32 (n, ...) on the device to float64, there."""
    flat = as_shaped(rows, (len(rows), prod(rows.shape[1:])))
    wide = device.empty(tuple(flat.shape), float, stream)
    if len(rows):
        device.compiled(converted)[device.blocks(len(rows)), device.THREADS, stream](flat, wide)
    return as_shaped(wide, tuple(rows.shape))


def converted(rows, out):
    """Write rows, shape (n, m), to out, of the same shape and another number type."""
    i = cuda.grid(1)
    if i < rows.shape[0]:
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]
