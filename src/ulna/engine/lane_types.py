"""Defines ``f64x8`` for Numba: eight float64 in the LLVM vector ``<8 x double>``.

With ``+ - * /``, comparisons and the operations of ``lanes`` defined for it, the same Python function that does scalar arithmetic
compiles to AVX-512, AVX2, SSE2 or NEON code for eight problems at a time, with no intrinsics in the algorithm.
"""

from llvmlite import ir
from numba import types
from numba.extending import models, register_model

from ulna.engine.width import WIDTH

F64, I32 = ir.DoubleType(), ir.IntType(32)
VECTOR = ir.VectorType(F64, WIDTH)
BITS = ir.VectorType(ir.IntType(1), WIDTH)


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
        super().__init__(manager, numba_type, VECTOR)


@register_model(LaneMask)
class _LaneMaskModel(models.PrimitiveModel):
    def __init__(self, manager, numba_type):
        super().__init__(manager, numba_type, BITS)


def number_type(*args):
    """The type of a result that mixes these arguments, or None if they are not numbers."""
    if not all(isinstance(a, (Lanes, types.Number)) for a in args):
        return None
    return lanes if any(isinstance(a, Lanes) for a in args) else types.float64


def cast(context, builder, value, from_type, to_type):
    """Any number as the given one; a scalar fills every lane."""
    if from_type == to_type:
        return value
    scalar = context.cast(builder, value, from_type, types.float64)
    if to_type == types.float64:
        return scalar
    undefined = ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(I32, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(I32, WIDTH), [0] * WIDTH))
