"""Runs one step of differential inverse kinematics over one configuration or a batch."""

from ulna.drivers.batch import gather, scatter_rows
from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, empty_rows, zero_rows
from ulna.engine.signatures import CONSTANTS, MATRIX, NUMBER, NUMBERS, TABLE, WHOLE
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.ik.bounded_least_squares import bounded_least_squares, velocity_bounds
from ulna.kernels.ik.search_layout import N_SYSTEM, N_TURNED
from ulna.kernels.spatial.elementary import all_in_range


@entry((TABLE, WHOLE, TABLE, CONSTANTS, NUMBER, NUMBER, NUMBERS, NUMBERS, NUMBERS, NUMBERS))
def differential_one(chain, expressed_in, limits, velocity_limits, damping, dt, q, twist, work, out):
    """Write the joint velocities to out, shape (n_dof,), for one q and one twist (6,). False if a number is out of range.

    work: at least N_PER_JOINT n_dof + N_SYSTEM + N_TURNED numbers (``kernels.ik.search_layout``), so that nothing is allocated.
    """
    n = out.shape[0]
    jacobian_rows, free_rows, work = work[: 6 * n], work[6 * n : 12 * n], work[12 * n :]
    system_rows, active_rows, work = work[:N_SYSTEM], work[N_SYSTEM : N_SYSTEM + n], work[N_SYSTEM + n :]
    goal_rows, bound_rows, rotated_rows = work[:n], work[n : 3 * n], work[3 * n : 3 * n + N_TURNED]
    chain_jacobian(chain, q, expressed_in, jacobian_rows, 6, 1)
    velocity_bounds(limits, velocity_limits, dt, q, bound_rows)
    bounded_least_squares(
        jacobian_rows, twist, damping, bound_rows, out, (active_rows, goal_rows, free_rows, system_rows, rotated_rows)
    )
    return all_in_range(q) and all_in_range(twist)


@entry((TABLE, WHOLE, TABLE, CONSTANTS, NUMBER, NUMBER, MATRIX, MATRIX, MATRIX))
def differential_batch(chain, expressed_in, limits, velocity_limits, damping, dt, q, twists, out):
    """``differential_one`` for q (n, n_dof), twists (n or 1, 6) and out (n, n_dof): eight rows at a time."""
    n, n_dof = out.shape
    q_rows, twist_rows, x_rows = zero_rows(n_dof), zero_rows(6), zero_rows(n_dof)
    jacobian_rows, bound_rows = empty_rows(6 * n_dof), empty_rows(2 * n_dof)
    scratch = (
        empty_rows(n_dof), empty_rows(n_dof), empty_rows(6 * n_dof), empty_rows(N_SYSTEM),
        empty_rows(N_TURNED),
    )  # fmt: skip
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        gather(twists, start, twist_rows)
        good &= all_in_range(q_rows) and all_in_range(twist_rows)
        chain_jacobian(chain, q_rows, expressed_in, jacobian_rows, 6, 1)
        velocity_bounds(limits, velocity_limits, dt, q_rows, bound_rows)
        bounded_least_squares(jacobian_rows, twist_rows, damping, bound_rows, x_rows, scratch)
        scatter_rows(x_rows, n_dof, out, start)
    return good
