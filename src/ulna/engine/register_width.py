"""Finds how many numbers one vector instruction of this machine computes."""

from functools import cache
from typing import Any

import numpy as np

from ulna.engine.ahead import is_ahead, level
from ulna.engine.decorators import routine
from ulna.engine.lanes import load, store

# The names of wide registers in assembly, x86's and then ARM's, with their bits; the first that is found is the widest.
_REGISTERS = (("%zmm", 512), ("%ymm", 256), ("%xmm", 128), (".2d", 128))

_OF_LEVEL = {"x86-64-v3": 256, "x86-64-v4": 512}


@routine
def _double(rows):
    store(rows, 0, load(rows, 0) + load(rows, 0))


@cache
def register_bits() -> int | None:
    """How wide the registers are that an addition of lanes uses [bits], by its machine code or its level; None without either.

    Not what the processor could do, but what was compiled: ``NUMBA_CPU_NAME`` and the compiler's settings decide too.
    """
    if is_ahead():
        return _OF_LEVEL.get(level(), 128)
    double: Any = _double
    if not hasattr(double, "inspect_asm"):
        return None
    double(np.zeros((1, 8)))
    code = next(iter(double.inspect_asm().values()))
    return next((bits for name, bits in _REGISTERS if name in code), None)
