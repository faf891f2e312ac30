"""Computes accelerations from torques, by the mass matrix and its Cholesky factor."""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store, where
from ulna.kernels.dynamics.cholesky import factorize, substitute

MIN_PIVOT = 1e-13  # of the inertia at a joint: less of it is rounding


@kernel
def accelerations(mass_rows, torque_rows, system_rows):
    """Solve M a = tau in the place of the torques.

    1. Factor the lower triangle of M. A pivot is the inertia that is left at a joint, with those before it free to move.
    2. Solve by substitution. A pivot below MIN_PIVOT of its diagonal entry is rounding: M is singular, and the result NaN.

    Args:
        mass_rows: M, entry (r, c) in row n r + c.
        torque_rows: tau, n rows; a, after the call.
        system_rows: Rows to work in, n (n + 1) / 2 + n.
    """
    n = torque_rows.shape[0]
    for r in range(n):
        for c in range(r + 1):
            store(system_rows, r * (r + 1) // 2 + c, load(mass_rows, n * r + c))
        store(system_rows, n * (n + 1) // 2 + r, load(torque_rows, r))
    factorize(system_rows, n)
    substitute(system_rows, n)
    regular = is_regular(mass_rows, system_rows, 0, n)
    for r in range(1, n):
        regular = regular & is_regular(mass_rows, system_rows, r, n)
    for r in range(n):
        store(torque_rows, r, where(regular, load(system_rows, n * (n + 1) // 2 + r), np.nan))


@kernel
def is_regular(mass_rows, system_rows, r, n):
    """Whether pivot r, whose root has its reciprocal in the factor, is more than rounding."""
    inverse = load(system_rows, r * (r + 1) // 2 + r)
    return inverse * inverse * load(mass_rows, n * r + r) < 1.0 / MIN_PIVOT
