"""Compiles the making of rows of lanes. Used by ``compiler``.

A row fills a cache line of 64 bytes. NumPy's and Numba's own arrays begin at multiples of 16 or 32 bytes: a row may then lie
across two lines, and each load and each store of it touches both.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.np.arrayobj import populate_array

from ulna.engine.lane_lowering import primitive
from ulna.engine.lanes import empty_rows, zero_rows
from ulna.engine.width import WIDTH

_ROW_BYTES = 8 * WIDTH
_ROWS = types.Array(types.float64, 2, "C")


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


for _function, _emit in ((empty_rows, _emit_empty_rows), (zero_rows, _emit_zero_rows)):
    primitive(_function, lambda n: _ROWS if isinstance(n, types.Integer) else None, _emit)
