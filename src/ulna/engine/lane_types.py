"""Defines ``f64x8`` for Numba: eight float64 in the LLVM vector ``<8 x double>``, with the operators of a float64.

With ``+ - * /``, comparisons and the operations of ``lanes`` defined for it, a Python function of scalar arithmetic compiles to
AVX-512, AVX2, SSE2 or NEON code. It solves eight problems at a time, with no intrinsics in the algorithm.
"""

import operator
from functools import wraps

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import NativeValue, box, lower_builtin, models, register_model, type_callable, unbox

from ulna.engine.lanes import WIDTH

F64, I32 = ir.DoubleType(), ir.IntType(32)
VECTOR = ir.VectorType(F64, WIDTH)
BITS = ir.VectorType(ir.IntType(1), WIDTH)


class Lanes(types.Type):
    """Eight float64 in one register."""

    def __init__(self):
        super().__init__(name=f"f64x{WIDTH}")


class LaneMask(types.Type):
    """Eight booleans: the result of comparing lanes."""

    def __init__(self):
        super().__init__(name=f"i1x{WIDTH}")


lanes, lane_mask = Lanes(), LaneMask()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, VECTOR)


@register_model(LaneMask)
class _LaneMaskModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, BITS)


@box(Lanes)
@box(LaneMask)
def _box(kind, value, context):
    """Refuse conversion: Python has no lanes, so only compiled code can call a function that returns them."""
    context.pyapi.err_set_string("PyExc_TypeError", "a number of lanes is for compiled code alone")
    return cgutils.get_null_value(context.pyapi.pyobj)


@unbox(Lanes)
@unbox(LaneMask)
def _unbox(kind, value, context):
    context.pyapi.err_set_string("PyExc_TypeError", "a number of lanes is for compiled code alone")
    return NativeValue(cgutils.get_null_value(context.context.get_value_type(kind)), is_error=cgutils.true_bit)


def number_type(*args):
    """The type of a result that mixes these arguments, or None if they are not numbers."""
    if not all(isinstance(a, (Lanes, types.Number)) for a in args):
        return None
    return lanes if any(isinstance(a, Lanes) for a in args) else types.float64


def cast(context, builder, value, from_type, to_type):
    """Convert a number to another type; a scalar fills every lane."""
    if from_type == to_type:
        return value
    scalar = context.cast(builder, value, from_type, types.float64)
    if to_type == types.float64:
        return scalar
    undefined = ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(I32, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(I32, WIDTH), [0] * WIDTH))


def _operator(op, emit, accepts, result):
    """Register an operator with Numba for arguments of which at least one is of lanes."""

    @type_callable(op)
    def _typing(context):
        return wraps(op)(lambda *args: result if accepts(*args) else None)

    def lower(context, builder, sig, args):
        values = args
        if accepts is _mix_of_lanes:
            values = [cast(context, builder, a, t, lanes) for a, t in zip(args, sig.args, strict=True)]
        return emit(builder, *values)

    for kinds in {
        _mix_of_lanes: [(Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)],
        _one_lanes: [(Lanes,)],
        _two_masks: [(LaneMask, LaneMask)],
    }[accepts]:
        lower_builtin(op, *kinds)(lower)


def _mix_of_lanes(*args):
    return len(args) == 2 and number_type(*args) == lanes


def _one_lanes(*args):
    return len(args) == 1 and args[0] == lanes


def _two_masks(*args):
    return len(args) == 2 and all(a == lane_mask for a in args)


def _fabs(builder, x):
    function_type = ir.FunctionType(VECTOR, [VECTOR])
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
_operator(operator.xor, lambda builder, x, y: builder.xor(x, y), _two_masks, lane_mask)
