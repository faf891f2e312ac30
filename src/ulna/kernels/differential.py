"""One step of a control loop: the joint velocities that give a link a twist as well as the limits allow (``box_least_squares``).

The bounds of entry j are the velocity limits, and what reaches the position limit at the end of the step: (limit - q) / dt. An
entry that stands beyond a limit is led back at no more than its velocity limit.
"""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.box_least_squares import box_least_squares
from ulna.kernels.compile import entry, kernel
from ulna.kernels.damped_step import N_SYSTEM
from ulna.kernels.elementary import maximum, minimum
from ulna.kernels.jacobian import chain_jacobian
from ulna.kernels.kinds import CONSTANTS, MATRIX, NUMBER, NUMBERS, TABLE, WHOLE
from ulna.kernels.lanes import WIDTH, load, splat, store


@kernel
def velocity_bounds(limits, velocity_limits, dt, q_rows, bound_rows):
    """Write the lower and then the upper bounds of the joint velocities."""
    n_dof = velocity_limits.shape[0]
    for j in range(n_dof):
        q = load(q_rows, j)
        fast = splat(velocity_limits[j], q)
        store(bound_rows, j, minimum(maximum((limits[0, j] - q) / dt, -fast), fast))
        store(bound_rows, n_dof + j, minimum(maximum((limits[1, j] - q) / dt, -fast), fast))


@entry((TABLE, WHOLE, TABLE, CONSTANTS, NUMBER, NUMBER, NUMBERS, NUMBERS, NUMBERS, NUMBERS))
def differential_one(chain, expressed_in, limits, velocity_limits, damping, dt, q, twist, work, out):
    """Write the joint velocities to out, shape (n_dof,), for one q and one twist (6,). False if a number is out of range.

    work: at least 27 + 16 n_dof numbers, so that nothing is allocated.
    """
    n = out.shape[0]
    jacobian_rows, free_rows, work = work[: 6 * n], work[6 * n : 12 * n], work[12 * n :]
    system_rows, held_rows, work = work[:N_SYSTEM], work[N_SYSTEM : N_SYSTEM + n], work[N_SYSTEM + n :]
    goal_rows, bound_rows = work[:n], work[n : 3 * n]
    chain_jacobian(chain, q, expressed_in, jacobian_rows, 6, 1)
    velocity_bounds(limits, velocity_limits, dt, q, bound_rows)
    box_least_squares(jacobian_rows, twist, damping, bound_rows, out, (held_rows, goal_rows, free_rows, system_rows))
    return all_in_range(q) and all_in_range(twist)


@entry((TABLE, WHOLE, TABLE, CONSTANTS, NUMBER, NUMBER, MATRIX, MATRIX, MATRIX))
def differential_batch(chain, expressed_in, limits, velocity_limits, damping, dt, q, twists, out):
    """The same for q (n, n_dof), twists (n or 1, 6) and out (n, n_dof): eight rows at a time."""
    n, n_dof = out.shape
    q_rows, twist_rows, x_rows = np.zeros((n_dof, WIDTH)), np.zeros((6, WIDTH)), np.zeros((n_dof, WIDTH))
    jacobian_rows, bound_rows = np.empty((6 * n_dof, WIDTH)), np.empty((2 * n_dof, WIDTH))
    scratch = (
        np.empty((n_dof, WIDTH)), np.empty((n_dof, WIDTH)), np.empty((6 * n_dof, WIDTH)), np.empty((N_SYSTEM, WIDTH)),
    )  # fmt: skip
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        gather(twists, start, twist_rows)
        good &= all_in_range(q_rows) and all_in_range(twist_rows)
        chain_jacobian(chain, q_rows, expressed_in, jacobian_rows, 6, 1)
        velocity_bounds(limits, velocity_limits, dt, q_rows, bound_rows)
        box_least_squares(jacobian_rows, twist_rows, damping, bound_rows, x_rows, scratch)
        for lane in range(WIDTH):
            for j in range(n_dof):
                out[min(start + lane, n - 1), j] = x_rows[j, lane]
    return good
