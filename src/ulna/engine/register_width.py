"""Finds how many numbers one vector instruction of this machine computes. Used by ``bench.machine``."""

from functools import cache
from typing import Any

import numpy as np

from ulna.engine.decorators import routine
from ulna.engine.lanes import load, store

# The names of wide registers in assembly, x86's and then ARM's, with their bits; the first that is found is the widest.
_REGISTERS = (("%zmm", 512), ("%ymm", 256), ("%xmm", 128), (".2d", 128))


@routine
def _double(rows):
    store(rows, 0, load(rows, 0) + load(rows, 0))


@cache
def register_bits() -> int | None:
    """How wide the registers are that an addition of lanes uses [bits], read from its machine code; None without the compiler.

    Not what the processor could do, but what was compiled: ``NUMBA_CPU_NAME`` and the compiler's settings decide too.
    """
    double: Any = _double
    if not hasattr(double, "inspect_asm"):
        return None
    double(np.zeros((1, 8)))
    code = next(iter(double.inspect_asm().values()))
    return next((bits for name, bits in _REGISTERS if name in code), None)
