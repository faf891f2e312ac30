"""Teaches Numba the operators of ``f64x8``, which a float64 already has."""

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin

from ulna.engine.lane_types import VECTOR, LaneMask, Lanes, cast, lane_mask, lanes, number_type
from ulna.engine.width import WIDTH


def _operator(op, emit, accepts, result):
    """Teach Numba an operator for arguments of which at least one is of lanes."""

    @infer_global(op)  # pyright: ignore[reportOptionalCall]
    class _Typing(AbstractTemplate):
        def generic(self, args, kws):
            return signature(result, *args) if accepts(*args) else None

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
