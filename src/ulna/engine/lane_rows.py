"""Compiles functions that allocate rows of lanes, and that load and store eight columns of a batch.

A load of eight columns reads eight rows of an array. Its result has one number of eight lanes per column, with one row of the
array in each lane. A store is the reverse.

A row fills a cache line of 64 bytes. NumPy's and Numba's own arrays begin at multiples of 16 or 32 bytes: a row may then span two
lines, and each load and each store of it touches both.

Eight rows of eight numbers are transposed in registers, which avoids 64 loads and 64 stores of single numbers. This has three
steps: an exchange of halves (four of the eight numbers), of quarters, and of neighbors. Halves need no instruction of their own,
since they are loaded and stored separately. Two steps of eight shuffles remain.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import overload

from ulna.engine.lane_lowering import primitive
from ulna.engine.lane_types import F64, I32, lanes
from ulna.engine.lanes import WIDTH, empty_rows, load_columns, store_columns, zero_rows
from ulna.engine.numba_private import ROWS, have, populate_array

_ROW_BYTES = 8 * WIDTH
_ROWS = types.Array(types.float64, 2, "C")
_HALF = WIDTH // 2
_STEPS = tuple(_HALF >> k for k in range(1, _HALF.bit_length()))  # 2, 1
_HALF_REGISTER = ir.VectorType(F64, _HALF)
_EIGHT = types.UniTuple(lanes, WIDTH)


def _emit_empty_rows(context, builder, sig, args):
    return _made(context, builder, sig, args)._getvalue()  # noqa: SLF001 - as Numba's own functions do


def _emit_zero_rows(context, builder, sig, args):
    rows = _made(context, builder, sig, args)
    cgutils.memset(builder, rows.data, builder.mul(rows.nitems, ir.Constant(rows.nitems.type, 8)), 0)
    return rows._getvalue()  # noqa: SLF001 - as Numba's own functions do


def _made(context, builder, sig, args):
    """A new array of n rows. Numba counts its users, and frees it after the last."""
    n = context.cast(builder, args[0], sig.args[0], types.intp)
    width, item, row = (ir.Constant(n.type, size) for size in (WIDTH, 8, _ROW_BYTES))
    rows = context.make_array(_ROWS)(context, builder)
    memory = context.nrt.meminfo_alloc_aligned(builder, builder.mul(n, row), _ROW_BYTES)
    populate_array(
        rows,
        data=builder.bitcast(context.nrt.meminfo_data(builder, memory), rows.data.type),
        shape=cgutils.pack_array(builder, [n, width]),
        strides=cgutils.pack_array(builder, [row, item]),
        itemsize=item,
        meminfo=memory,
    )
    return rows


if have(ROWS):
    for _function, _emit in ((empty_rows, _emit_empty_rows), (zero_rows, _emit_zero_rows)):
        primitive(_function, lambda n: _ROWS if isinstance(n, types.Integer) else None, _emit)
else:
    overload(empty_rows)(lambda n: lambda n: np.empty((n, WIDTH)))
    overload(zero_rows)(lambda n: lambda n: np.zeros((n, WIDTH)))


def _halves_of_rows(context, builder, array_type, array, index_types, indices, *, beyond_is_last):
    """Pointers to both halves of eight columns from k on, of eight rows from i on.

    The axes after the first form a row.
    """
    i, k = (context.cast(builder, index, kind, types.intp) for index, kind in zip(indices, index_types, strict=True))
    array = context.make_array(array_type)(context, builder, array)
    n, *lengths = cgutils.unpack_tuple(builder, array.shape, array_type.ndim)
    columns, last = ir.Constant(i.type, 1), builder.sub(n, ir.Constant(n.type, 1))
    for length in lengths:
        columns = builder.mul(columns, length)
    halves = []
    for lane in range(WIDTH):
        row = builder.add(i, ir.Constant(i.type, lane))
        if beyond_is_last:
            row = builder.select(builder.icmp_signed("<", row, last), row, last)
        first = builder.gep(array.data, [builder.add(builder.mul(row, columns), k)])
        first = builder.bitcast(first, _HALF_REGISTER.as_pointer())
        halves.append((first, builder.gep(first, [ir.Constant(I32, 1)])))
    return halves


def _emit_load_columns(context, builder, sig, args):
    rows = _halves_of_rows(context, builder, sig.args[0], args[0], sig.args[1:], args[1:], beyond_is_last=True)
    loaded = [[builder.load(half, align=8) for half in row] for row in rows]
    pairs = [(loaded[k][half], loaded[k + _HALF][half]) for half in range(2) for k in range(_HALF)]
    numbers = [_shuffled(builder, *pair, range(WIDTH)) for pair in pairs]
    return context.make_tuple(builder, sig.return_type, _exchanged(builder, numbers))


def _emit_store_columns(context, builder, sig, args):
    rows = _halves_of_rows(context, builder, sig.args[0], args[0], sig.args[1:3], args[1:3], beyond_is_last=False)
    numbers = _exchanged(builder, cgutils.unpack_tuple(builder, args[3], WIDTH))
    for lane, row in enumerate(rows):
        first = lane // _HALF * _HALF
        for half, pointer in enumerate(row):
            number = numbers[half * _HALF + lane % _HALF]
            builder.store(_shuffled(builder, number, number, range(first, first + _HALF)), pointer, align=8)
    return context.get_dummy_value()


def _exchanged(builder, numbers):
    """Exchange, between numbers ``step`` apart, the lanes that are ``step`` apart: for 2 and for 1. Halves stay in place."""
    numbers = list(numbers)
    for step in _STEPS:
        low = [lane if lane & step == 0 else WIDTH + lane - step for lane in range(WIDTH)]
        high = [lane + step if lane & step == 0 else WIDTH + lane for lane in range(WIDTH)]
        for k in range(WIDTH):
            if k & step == 0:
                pair = numbers[k], numbers[k + step]
                numbers[k], numbers[k + step] = (_shuffled(builder, *pair, order) for order in (low, high))
    return numbers


def _shuffled(builder, x, y, order):
    return builder.shuffle_vector(x, y, ir.Constant(ir.VectorType(I32, len(order)), list(order)))


def _is_batch(array):
    return isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64 and array.ndim > 1


def _are_places(*numbers):
    return all(isinstance(number, types.Integer) for number in numbers)


primitive(load_columns, lambda array, i, k: _EIGHT if _is_batch(array) and _are_places(i, k) else None, _emit_load_columns)
primitive(
    store_columns,
    lambda array, i, k, numbers: types.void if _is_batch(array) and _are_places(i, k) and numbers == _EIGHT else None,
    _emit_store_columns,
)
