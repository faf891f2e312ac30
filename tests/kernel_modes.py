"""Runs a probe in every mode of the generic number that this process has.

A probe is a function ``probe(*tables, in_rows, out_rows)``. It loads its numbers from rows, calls kernels, and stores their
results. The same source runs in four modes:

======= ============================================================================================
float64 compiled over rows of shape (n,), one problem after the other
f64x8   compiled over rows of shape (n, 8), eight problems at a time
scalars under ``NUMBA_DISABLE_JIT=1``: plain Python over rows of shape (n,)
arrays  under ``NUMBA_DISABLE_JIT=1``: plain NumPy over rows of shape (n, width), all problems at once
======= ============================================================================================

So the tests of kernels run twice, with and without the compiler. ``test_three_modes`` compares the modes directly.
"""

from functools import cache

import numpy as np

from ulna.engine.decorators import is_plain, routine
from ulna.engine.lanes import WIDTH

COMPILED = not is_plain()
MODES = ("float64", "f64x8") if COMPILED else ("scalars", "arrays")

compiled = cache(routine)  # under NUMBA_DISABLE_JIT=1 the function itself


def run(mode, probe, inputs, n_outputs, *tables):
    """Outputs of shape (n_outputs, n) for inputs of shape (n_inputs, n): every column is a problem of its own."""
    inputs = np.atleast_2d(np.asarray(inputs, dtype=np.float64))
    n, function = inputs.shape[1], compiled(probe)
    outputs = np.full((n_outputs, n), np.nan)
    with np.errstate(all="ignore"):  # the compiled modes raise no flags either
        if mode in ("float64", "scalars"):
            for k in range(n):
                out_rows = np.full(n_outputs, np.nan)
                function(*tables, np.ascontiguousarray(inputs[:, k]), out_rows)
                outputs[:, k] = out_rows
            return outputs
        width = WIDTH if mode == "f64x8" else n
        for start in range(0, n, width):
            columns = np.minimum(np.arange(start, start + width), n - 1)
            out_rows = np.full((n_outputs, width), np.nan)
            function(*tables, np.ascontiguousarray(inputs[:, columns]), out_rows)
            outputs[:, columns] = out_rows
    return outputs
