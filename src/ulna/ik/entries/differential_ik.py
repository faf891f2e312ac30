"""Runs one step of differential inverse kinematics over one configuration or a batch."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, empty_rows, zero_rows
from ulna.engine.signatures import CONSTANTS, MATRIX, NUMBER, NUMBERS, TABLE, WHOLE, Group
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.ik.bounded_least_squares import bounded_least_squares, velocity_bounds
from ulna.kernels.ik.search_layout import N_SYSTEM, N_TURNED
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kinematics.entries.batch import gather, scatter_rows


class ControlStep(NamedTuple):
    """The settings that all rows of a batch share.

    Attributes:
        chain: The chain to the link.
        expressed_in: The axes of the twist (``kernels.layout``).
        limits: Position limits, shape (2, n_dof).
        velocity_limits: Shape (n_dof,).
        damping: The factor of the squared velocities.
        dt: The duration of a step [s].
    """

    chain: NDArray[np.float64]
    expressed_in: int
    limits: NDArray[np.float64]
    velocity_limits: NDArray[np.float64]
    damping: float
    dt: float


_STEP = Group((TABLE, WHOLE, TABLE, CONSTANTS, NUMBER, NUMBER), ControlStep)


@entry((_STEP, NUMBERS, NUMBERS, NUMBERS, NUMBERS))
def differential_one(step, q, twist, work, out):
    """Write the joint velocities to out, shape (n_dof,), for one q and one twist (6,). False if out of range.

    work: At least N_PER_JOINT n_dof + N_SYSTEM + N_TURNED numbers (``kernels.ik.search_layout``), so that nothing is allocated.
    """
    n = out.shape[0]
    jacobian_rows, free_rows, work = work[: 6 * n], work[6 * n : 12 * n], work[12 * n :]
    system_rows, active_rows, work = work[:N_SYSTEM], work[N_SYSTEM : N_SYSTEM + n], work[N_SYSTEM + n :]
    goal_rows, bound_rows, rotated_rows = work[:n], work[n : 3 * n], work[3 * n : 3 * n + N_TURNED]
    chain_jacobian(step.chain, q, step.expressed_in, jacobian_rows, 6, 1)
    velocity_bounds(step.limits, step.velocity_limits, step.dt, q, bound_rows)
    scratch = active_rows, goal_rows, free_rows, system_rows, rotated_rows
    bounded_least_squares(jacobian_rows, twist, step.damping, bound_rows, out, scratch)
    return all_in_range(q) and all_in_range(twist)


@entry((_STEP, MATRIX, MATRIX, MATRIX))
def differential_batch(step, q, twists, out):
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
        chain_jacobian(step.chain, q_rows, step.expressed_in, jacobian_rows, 6, 1)
        velocity_bounds(step.limits, step.velocity_limits, step.dt, q_rows, bound_rows)
        bounded_least_squares(jacobian_rows, twist_rows, step.damping, bound_rows, x_rows, scratch)
        scatter_rows(x_rows, n_dof, out, start)
    return good
