"""A number that is eight numbers: the type ``f64x8`` for Numba, and the primitives that every kernel is written in.

Numba is taught a type whose machine form is the LLVM vector ``<8 x double>``. With ``+ - * /``, comparisons and the
functions below defined for it, the same Python function that does scalar arithmetic compiles to AVX-512, AVX2, SSE2 or
NEON code that treats eight problems at a time, with no intrinsics in the algorithm.

Each primitive is a plain function with a NumPy meaning (what runs under ``NUMBA_DISABLE_JIT=1``) and a typed lowering
(what is compiled). Kernels call these and not ``math.*``, which refuses arrays. Operations on vectors carry no
fast-math flags of their own: Numba gives them those of the function in which they stand.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from ulna.engine.width import WIDTH

_F64 = ir.DoubleType()
_VECTOR = ir.VectorType(_F64, WIDTH)
_BITS = ir.VectorType(ir.IntType(1), WIDTH)
_I8, _I32 = ir.IntType(8), ir.IntType(32)


class Lanes(types.Type):
    """Eight float64 in one register."""

    def __init__(self):
        super().__init__(name=f"f64x{WIDTH}")


class LaneMask(types.Type):
    """Eight truth values: what a comparison of lanes gives."""

    def __init__(self):
        super().__init__(name=f"i1x{WIDTH}")


lanes, lane_mask = Lanes(), LaneMask()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, _VECTOR)


@register_model(LaneMask)
class _LaneMaskModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, _BITS)


# ---- what the primitives mean: NumPy ------------------------------------------------------------------------------
def sqrt(x):
    """Square root of a number."""
    return np.sqrt(x)


def rint(x):
    """Nearest integer, ties to even."""
    return np.rint(x)


def where(mask, x, y):
    """x where the mask is true, y elsewhere: how a kernel chooses without branching."""
    return np.where(mask, x, y)[()]


def logical_not(mask):
    """The mask turned round (``~`` would make -2 of a Python bool)."""
    return np.logical_not(mask)


def any_lane(mask):
    """True if any lane of the mask is: a plain bool, fit for ``if``."""
    return bool(np.any(mask))


def lane_bits(mask):
    """The mask as a whole number: bit k is lane k. For a search that one number leads and eight things await."""
    return int(np.sum(np.asarray(mask, dtype=np.int64) << np.arange(np.size(mask))))


def lowest_bit(bits):
    """The place of the lowest bit that is set in a whole number above zero."""
    return (bits & -bits).bit_length() - 1


def splat(x, like):
    """The plain number x as a number of the kind of ``like``."""
    return np.full(np.shape(like), x, dtype=np.float64)[()]


def load(rows, i):
    """Number i of rows."""
    return rows[i].copy()


def store(rows, i, x):
    """Write number x to place i of rows."""
    rows[i] = x


def lane_count(x):
    """How many problems a number holds: 1 for a plain one."""
    return np.size(x)


def lane_of(x, lane):
    """A number's value in one lane: a plain number."""
    return np.ravel(x)[lane]


def with_lane(x, lane, y):
    """A number with the plain number y in one lane."""
    values = np.array(x, dtype=np.float64)
    values.ravel()[lane] = y
    return values[()]


# ---- how the compiler sees them -----------------------------------------------------------------------------------
def _primitive(function, typing, emit):
    """Register ``function`` with a typing rule over argument types and one lowering for every signature it allows."""

    @infer_global(function)  # pyright: ignore[reportOptionalCall]
    class _Typing(AbstractTemplate):
        def generic(self, args, kws):
            result = None if kws else typing(*args)
            return None if result is None else signature(result, *args)

    lower_builtin(function, types.VarArg(types.Any))(emit)


def _is_rows(array):
    return isinstance(array, types.Array) and array.layout == "C" and array.dtype == types.float64 and array.ndim in (1, 2)


def _row_type(array):
    return types.float64 if array.ndim == 1 else lanes


def _number_type(*args):
    """The type of a result that mixes these arguments, or None if they are not numbers."""
    if not all(isinstance(a, (Lanes, types.Number)) for a in args):
        return None
    return lanes if any(isinstance(a, Lanes) for a in args) else types.float64


def _cast(context, builder, value, from_type, to_type):
    """Any number as the given one; a scalar fills every lane."""
    if from_type == to_type:
        return value
    scalar = context.cast(builder, value, from_type, types.float64)
    if to_type == types.float64:
        return scalar
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(_I32, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(_I32, WIDTH), [0] * WIDTH))


def _llvm_unary(name):
    def emit(context, builder, sig, args):
        vector = sig.return_type == lanes
        kind, suffix = (_VECTOR, f"v{WIDTH}f64") if vector else (_F64, "f64")
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(kind, [kind]), f"llvm.{name}.{suffix}")
        return builder.call(function, [_cast(context, builder, args[0], sig.args[0], sig.return_type)])

    return emit


def _emit_where(context, builder, sig, args):
    x, y = (_cast(context, builder, a, t, sig.return_type) for a, t in zip(args[1:], sig.args[1:], strict=True))
    return builder.select(args[0], x, y)


def _where_type(mask, x, y):
    number = _number_type(x, y)
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
    return _cast(context, builder, args[0], sig.args[0], sig.return_type)


def _row_pointer(context, builder, array_type, array, index_type, index):
    """Pointer to row ``index``: rows lie one after the other, WIDTH doubles each if they are lanes."""
    index = context.cast(builder, index, index_type, types.intp)
    data = context.make_array(array_type)(context, builder, array).data
    if array_type.ndim == 1:
        return builder.gep(data, [index])
    start = builder.mul(index, ir.Constant(index.type, WIDTH))
    return builder.bitcast(builder.gep(data, [start]), _VECTOR.as_pointer())


def _emit_load(context, builder, sig, args):
    pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    return builder.load(pointer, align=8)


def _emit_store(context, builder, sig, args):
    pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    builder.store(_cast(context, builder, args[2], sig.args[2], _row_type(sig.args[0])), pointer, align=8)
    return context.get_dummy_value()


def _emit_lane_count(context, builder, sig, args):
    return context.get_constant(types.intp, WIDTH if sig.args[0] == lanes else 1)


def _emit_lane_of(context, builder, sig, args):
    if sig.args[0] != lanes:
        return _cast(context, builder, args[0], sig.args[0], types.float64)
    return builder.extract_element(args[0], context.cast(builder, args[1], sig.args[1], types.int32))


def _emit_with_lane(context, builder, sig, args):
    scalar = _cast(context, builder, args[2], sig.args[2], types.float64)
    if sig.return_type != lanes:
        return scalar
    return builder.insert_element(args[0], scalar, context.cast(builder, args[1], sig.args[1], types.int32))


def _lane_type(x, lane, *y):
    fits = _number_type(x) is not None and isinstance(lane, types.Integer) and all(isinstance(z, types.Number) for z in y)
    return (_number_type(x) if y else types.float64) if fits else None


def _load_type(rows, i):
    return _row_type(rows) if _is_rows(rows) and isinstance(i, types.Integer) else None


def _store_type(rows, i, x):
    fits = _load_type(rows, i) is not None and _number_type(x, _row_type(rows)) == _row_type(rows)
    return types.void if fits else None


def _mask_type(*masks):
    return masks[0] if all(m == masks[0] and isinstance(m, (LaneMask, types.Boolean)) for m in masks) else None


_primitive(sqrt, _number_type, _llvm_unary("sqrt"))
_primitive(rint, _number_type, _llvm_unary("rint"))
_primitive(where, _where_type, _emit_where)
_primitive(logical_not, _mask_type, lambda context, builder, sig, args: builder.not_(args[0]))
_primitive(any_lane, lambda mask: types.boolean if _mask_type(mask) else None, _emit_any_lane)
_primitive(lane_bits, lambda mask: types.intp if _mask_type(mask) else None, _emit_lane_bits)
_primitive(lowest_bit, lambda bits: types.intp if bits == types.intp else None, _emit_lowest_bit)
_primitive(splat, lambda x, like: _number_type(like) if isinstance(x, types.Number) else None, _emit_splat)
_primitive(lane_count, lambda x: types.intp if _number_type(x) is not None else None, _emit_lane_count)
_primitive(lane_of, _lane_type, _emit_lane_of)
_primitive(with_lane, _lane_type, _emit_with_lane)
_primitive(load, _load_type, _emit_load)
_primitive(store, _store_type, _emit_store)


# ---- operators of lanes: what Python's own numbers already have ---------------------------------------------------
def _operator(op, emit, accepts, result):
    """Teach Numba an operator for arguments of which at least one is of lanes."""

    @infer_global(op)  # pyright: ignore[reportOptionalCall]
    class _Typing(AbstractTemplate):
        def generic(self, args, kws):
            return signature(result, *args) if accepts(*args) else None

    def lower(context, builder, sig, args):
        values = args
        if accepts is _mix_of_lanes:
            values = [_cast(context, builder, a, t, lanes) for a, t in zip(args, sig.args, strict=True)]
        return emit(builder, *values)

    for kinds in {
        _mix_of_lanes: [(Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)],
        _one_lanes: [(Lanes,)],
        _two_masks: [(LaneMask, LaneMask)],
    }[accepts]:
        lower_builtin(op, *kinds)(lower)


def _mix_of_lanes(*args):
    return len(args) == 2 and _number_type(*args) == lanes


def _one_lanes(*args):
    return len(args) == 1 and args[0] == lanes


def _two_masks(*args):
    return len(args) == 2 and all(a == lane_mask for a in args)


def _fabs(builder, x):
    function_type = ir.FunctionType(_VECTOR, [_VECTOR])
    return builder.call(cgutils.get_or_insert_function(builder.module, function_type, f"llvm.fabs.v{WIDTH}f64"), [x])


_operator(operator.add, lambda builder, x, y: builder.fadd(x, y), _mix_of_lanes, lanes)
_operator(operator.sub, lambda builder, x, y: builder.fsub(x, y), _mix_of_lanes, lanes)
_operator(operator.mul, lambda builder, x, y: builder.fmul(x, y), _mix_of_lanes, lanes)
_operator(operator.truediv, lambda builder, x, y: builder.fdiv(x, y), _mix_of_lanes, lanes)
for _op, _sign in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _operator(_op, lambda builder, x, y, sign=_sign: builder.fcmp_ordered(sign, x, y), _mix_of_lanes, lane_mask)
_operator(operator.neg, lambda builder, x: builder.fneg(x), _one_lanes, lanes)
_operator(abs, _fabs, _one_lanes, lanes)
_operator(operator.and_, lambda builder, x, y: builder.and_(x, y), _two_masks, lane_mask)
_operator(operator.or_, lambda builder, x, y: builder.or_(x, y), _two_masks, lane_mask)
