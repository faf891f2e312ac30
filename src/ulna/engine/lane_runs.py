"""Compiles loads and stores of eight neighbouring numbers of a batch, and transposition of eight of them. Used by ``compiler``.

Eight rows of a batch are loaded whole, and transposed in registers: 24 shuffles where number by number there would be 64 loads
and 64 stores. Halves are exchanged first, then quarters, then neighbours: where a register holds four doubles or two, the
first of these steps need no instruction.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils

from ulna.engine.lane_lowering import primitive
from ulna.engine.lane_types import I32, VECTOR, lanes
from ulna.engine.lanes import load_run, store_run, transposed
from ulna.engine.width import WIDTH

_STEPS = tuple(WIDTH >> k for k in range(1, WIDTH.bit_length()))  # 4, 2, 1


def _run_pointer(context, builder, array_type, array, index_types, indices):
    """Pointer to eight numbers from place k of row i on; a row has the items of all axes but the first."""
    i, k = (context.cast(builder, index, kind, types.intp) for index, kind in zip(indices, index_types, strict=True))
    array = context.make_array(array_type)(context, builder, array)
    row = ir.Constant(i.type, 1)
    for length in cgutils.unpack_tuple(builder, array.shape, array_type.ndim)[1:]:
        row = builder.mul(row, length)
    first = builder.gep(array.data, [builder.add(builder.mul(i, row), k)])
    return builder.bitcast(first, VECTOR.as_pointer())


def _emit_load_run(context, builder, sig, args):
    return builder.load(_run_pointer(context, builder, sig.args[0], args[0], sig.args[1:], args[1:]), align=8)


def _emit_store_run(context, builder, sig, args):
    builder.store(args[3], _run_pointer(context, builder, sig.args[0], args[0], sig.args[1:3], args[1:3]), align=8)
    return context.get_dummy_value()


def _emit_transposed(context, builder, sig, args):
    """Exchange, between numbers ``step`` apart, the lanes that are ``step`` apart: for 4, for 2 and for 1."""
    numbers = list(args)
    for step in _STEPS:
        low = [lane if lane & step == 0 else WIDTH + lane - step for lane in range(WIDTH)]
        high = [lane + step if lane & step == 0 else WIDTH + lane for lane in range(WIDTH)]
        for k in range(WIDTH):
            if k & step == 0:
                pair = numbers[k], numbers[k + step]
                numbers[k], numbers[k + step] = (_shuffled(builder, *pair, order) for order in (low, high))
    return context.make_tuple(builder, sig.return_type, numbers)


def _shuffled(builder, x, y, order):
    return builder.shuffle_vector(x, y, ir.Constant(ir.VectorType(I32, WIDTH), order))


def _is_batch(array):
    return isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64 and array.ndim > 1


def _are_places(*numbers):
    return all(isinstance(number, types.Integer) for number in numbers)


primitive(load_run, lambda array, i, k: lanes if _is_batch(array) and _are_places(i, k) else None, _emit_load_run)
primitive(
    store_run,
    lambda array, i, k, x: types.void if _is_batch(array) and _are_places(i, k) and x == lanes else None,
    _emit_store_run,
)
primitive(
    transposed,
    lambda *numbers: types.UniTuple(lanes, WIDTH) if numbers == (lanes,) * WIDTH else None,
    _emit_transposed,
)
