"""Computes the step of the Jacobian transpose, steepest descent.

Source: Wolovich and Elliott (CDC 1984); the step length is Buss's (Introduction to Inverse Kinematics, 2004, eq. 7).

1. With the error e and J at q, the direction of steepest descent of |e|^2 / 2 is g = J' e.
2. Along g, J g is the change of the pose; the step alpha = <e, J g> / <J g, J g> would come nearest to the target if the arm were
   linear.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, store, where
from ulna.kernels.ik.damped_system import add_column, gradient


@kernel
def transpose_step(jacobian_rows, n_dof, e, step_rows):
    """Write alpha g, entry by entry of q."""
    alpha = step_length(jacobian_rows, n_dof, e)
    for j in range(n_dof):
        store(step_rows, j, alpha * gradient(jacobian_rows, j, e))


@kernel
def step_length(jacobian_rows, n_dof, e):
    """<e, J g> / <J g, J g> for g = J' e; 0 where g is."""
    zero = splat(0.0, e[0])
    v = zero, zero, zero, zero, zero, zero
    for j in range(n_dof):
        v = add_column(v, jacobian_rows, j, gradient(jacobian_rows, j, e))
    along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2] + e[3] * v[3] + e[4] * v[4] + e[5] * v[5]
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3] + v[4] * v[4] + v[5] * v[5]
    return where(square > 0.0, along / where(square > 0.0, square, 1.0), 0.0)
