"""Computes accelerations from torques with the Cholesky factor of the mass matrix."""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store, where
from ulna.kernels.dynamics.cholesky import factorize, substitute

MIN_PIVOT = 1e-13  # minimum pivot relative to the diagonal entry: a smaller one is rounding


@kernel
def accelerations(mass_rows, torque_rows, system_rows):
    """Solve M a = tau in place of the torques.

    1. Factor the lower triangle of M. A pivot is the inertia at a joint while all previous joints are free to move.
    2. Solve by substitution. If a pivot is below MIN_PIVOT times its diagonal entry, M is singular and the result is NaN.

    Args:
        mass_rows: M, with entry (r, c) in row n r + c.
        torque_rows: tau, n rows; overwritten by a.
        system_rows: Workspace of n (n + 1) / 2 + n rows.
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
    """Whether pivot r is more than rounding; the factor has the reciprocal of its root."""
    inverse = load(system_rows, r * (r + 1) // 2 + r)
    return inverse * inverse * load(mass_rows, n * r + r) < 1.0 / MIN_PIVOT
