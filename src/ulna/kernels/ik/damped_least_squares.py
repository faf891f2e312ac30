"""Computes the step of damped least squares with constant damping.

Source: Wampler (IEEE Trans. Systems, Man and Cybernetics 1986); Nakamura and Hanafusa (J. Dyn. Sys., Meas., Control 1986).

dq = J' (J J' + lambda I)^-1 e minimises |J dq - e|^2 + lambda |dq|^2: near a singularity, where an undamped step would be
enormous, the second term keeps it short. Away from one it costs a share lambda / sigma^2 of the error at each step, so the error
falls by a factor and not quadratically. Levenberg-Marquardt (``multi_start``) reduces lambda with the error.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, store
from ulna.kernels.ik.damped_system import back_to_joints, solve_damped

DAMPING = 0.01  # lambda


@kernel
def damped_step(jacobian_rows, n_dof, e, system_rows, step_rows):
    """Write J' (J J' + lambda I)^-1 e."""
    solve_damped(jacobian_rows, n_dof, splat(DAMPING, e[0]), e, system_rows)
    for j in range(n_dof):
        store(step_rows, j, back_to_joints(jacobian_rows, j, system_rows))
