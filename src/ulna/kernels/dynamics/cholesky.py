"""Solves a system with a symmetric positive definite matrix by its Cholesky factor.

It works for any number of unknowns. The solver for six unknowns (``kernels.ik.damped_system``) is separate: with the number as
an argument, the search on a GPU would spill a third more registers.

The rows of a system of n unknowns have the lower triangle of the matrix; entry (r, c) is row r (r + 1) / 2 + c. The n numbers of
the right-hand side follow.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, sqrt, store


@kernel
def factorize(system_rows, n):
    """Replace the lower triangle by its Cholesky factor L, with the diagonal inverted."""
    for r in range(n):
        for c in range(r + 1):
            total = load(system_rows, r * (r + 1) // 2 + c)
            for k in range(c):
                total = total - load(system_rows, r * (r + 1) // 2 + k) * load(system_rows, c * (c + 1) // 2 + k)
            if r == c:
                store(system_rows, r * (r + 1) // 2 + c, 1.0 / sqrt(total))
            else:
                store(system_rows, r * (r + 1) // 2 + c, total * load(system_rows, c * (c + 1) // 2 + c))


@kernel
def substitute(system_rows, n):
    """Solve L z = e, then L' y = z, in place of the n numbers e after the factor."""
    first = n * (n + 1) // 2
    for r in range(n):
        total = load(system_rows, first + r)
        for k in range(r):
            total = total - load(system_rows, r * (r + 1) // 2 + k) * load(system_rows, first + k)
        store(system_rows, first + r, total * load(system_rows, r * (r + 1) // 2 + r))
    for s in range(n):
        r = n - 1 - s
        total = load(system_rows, first + r)
        for k in range(r + 1, n):
            total = total - load(system_rows, k * (k + 1) // 2 + r) * load(system_rows, first + k)
        store(system_rows, first + r, total * load(system_rows, r * (r + 1) // 2 + r))
