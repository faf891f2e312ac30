"""Registers the operations of ``lanes`` with Numba: their typing rules and their LLVM code.

Operations on vectors have no fast-math flags of their own: Numba adds those of the function that contains them.
"""

from functools import wraps

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable

from ulna.engine.lane_types import F64, VECTOR, LaneMask, cast, lanes, number_type
from ulna.engine.lanes import (
    WIDTH,
    any_lane,
    lane_bits,
    lane_count,
    lane_of,
    load,
    logical_not,
    lowest_bit,
    rint,
    splat,
    sqrt,
    store,
    where,
    with_lane,
)

_I8 = ir.IntType(8)


def primitive(function, typing, emit):
    """Register ``function`` with a typing rule over argument types and one lowering for every signature it allows."""

    @type_callable(function)
    def _typing(context):
        @wraps(function)  # it has its signature too, by which Numba passes arguments
        def typer(*args):
            return typing(*args)

        return typer

    lower_builtin(function, types.VarArg(types.Any))(emit)


def _is_rows(array):
    return isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64 and array.ndim in (1, 2)


def _row_type(array):
    return types.float64 if array.ndim == 1 else lanes


def _call(builder, name, kind, value):
    return builder.call(cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), name), [value])


def _llvm_unary(name):
    """An operation that LLVM itself has, for a double and for a vector."""

    def emit(context, builder, sig, args):
        kind, suffix = (VECTOR, f"v{WIDTH}f64") if sig.return_type == lanes else (F64, "f64")
        return _call(builder, f"llvm.{name}.{suffix}", kind, cast(context, builder, args[0], sig.args[0], sig.return_type))

    return emit


def _emit_rint(context, builder, sig, args):
    """Emit LLVM's ``rint``, except for CUDA, whose compiler lacks it: its library function gives the same result."""
    if builder.module.triple.startswith("nvptx"):
        return _call(builder, "__nv_rint", F64, context.cast(builder, args[0], sig.args[0], types.float64))
    return _llvm_unary("rint")(context, builder, sig, args)


def _emit_where(context, builder, sig, args):
    x, y = (cast(context, builder, a, t, sig.return_type) for a, t in zip(args[1:], sig.args[1:], strict=True))
    return builder.select(args[0], x, y)


def _where_type(mask, x, y):
    number = number_type(x, y)
    if isinstance(mask, LaneMask) and number is not None:
        return lanes
    return number if isinstance(mask, types.Boolean) else None


def _emit_any_lane(context, builder, sig, args):
    if isinstance(sig.args[0], LaneMask):
        return builder.icmp_unsigned("!=", builder.bitcast(args[0], _I8), ir.Constant(_I8, 0))
    return args[0]


def _emit_lane_bits(context, builder, sig, args):
    bits = builder.bitcast(args[0], _I8) if isinstance(sig.args[0], LaneMask) else args[0]
    return builder.zext(bits, context.get_value_type(types.intp))


def _emit_lowest_bit(context, builder, sig, args):
    return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))


def _emit_splat(context, builder, sig, args):
    return cast(context, builder, args[0], sig.args[0], sig.return_type)


def _row_pointer(context, builder, array_type, array, index_type, index):
    """Pointer to row ``index``: rows are contiguous, WIDTH doubles each for lanes."""
    index = context.cast(builder, index, index_type, types.intp)
    data = context.make_array(array_type)(context, builder, array).data
    if array_type.ndim == 1:
        return builder.gep(data, [index])
    start = builder.mul(index, ir.Constant(index.type, WIDTH))
    return builder.bitcast(builder.gep(data, [start]), VECTOR.as_pointer())


def _emit_load(context, builder, sig, args):
    pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    return builder.load(pointer, align=8)


def _emit_store(context, builder, sig, args):
    pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    builder.store(cast(context, builder, args[2], sig.args[2], _row_type(sig.args[0])), pointer, align=8)
    return context.get_dummy_value()


def _emit_lane_count(context, builder, sig, args):
    return context.get_constant(types.intp, WIDTH if sig.args[0] == lanes else 1)


def _emit_lane_of(context, builder, sig, args):
    if sig.args[0] != lanes:
        return cast(context, builder, args[0], sig.args[0], types.float64)
    return builder.extract_element(args[0], context.cast(builder, args[1], sig.args[1], types.int32))


def _emit_with_lane(context, builder, sig, args):
    scalar = cast(context, builder, args[2], sig.args[2], types.float64)
    if sig.return_type != lanes:
        return scalar
    return builder.insert_element(args[0], scalar, context.cast(builder, args[1], sig.args[1], types.int32))


def _lane_type(x, lane, *y):
    fits = number_type(x) is not None and isinstance(lane, types.Integer) and all(isinstance(z, types.Number) for z in y)
    return (number_type(x) if y else types.float64) if fits else None


def _load_type(rows, i):
    return _row_type(rows) if _is_rows(rows) and isinstance(i, types.Integer) else None


def _store_type(rows, i, x):
    fits = _load_type(rows, i) is not None and number_type(x, _row_type(rows)) == _row_type(rows)
    return types.void if fits else None


def _mask_type(*masks):
    return masks[0] if all(m == masks[0] and isinstance(m, (LaneMask, types.Boolean)) for m in masks) else None


primitive(sqrt, number_type, _llvm_unary("sqrt"))
primitive(rint, number_type, _emit_rint)
primitive(where, _where_type, _emit_where)
primitive(logical_not, _mask_type, lambda context, builder, sig, args: builder.not_(args[0]))
primitive(any_lane, lambda mask: types.boolean if _mask_type(mask) else None, _emit_any_lane)
primitive(lane_bits, lambda mask: types.intp if _mask_type(mask) else None, _emit_lane_bits)
primitive(lowest_bit, lambda bits: types.intp if bits == types.intp else None, _emit_lowest_bit)
primitive(splat, lambda x, like: number_type(like) if isinstance(x, types.Number) else None, _emit_splat)
primitive(lane_count, lambda x: types.intp if number_type(x) is not None else None, _emit_lane_count)
primitive(lane_of, _lane_type, _emit_lane_of)
primitive(with_lane, _lane_type, _emit_with_lane)
primitive(load, _load_type, _emit_load)
primitive(store, _store_type, _emit_store)
