"""Improves configurations that nearly reach their targets, by Newton steps of the forward kinematics.

1. Evaluate the pose error and the Jacobian at q.
2. Move by J' (J J' + lambda I)^-1 e with lambda = |e|^2 + 1e-13, which is Newton's step but where J has no inverse; within
   bounds, and without the joints that are at a bound and would be pushed beyond it.
3. Keep the step of a lane if its error is smaller then.
"""

from ulna.engine.decorators import shared_routine
from ulna.engine.lanes import any_lane, load, sqrt, store, where
from ulna.kernels.chain.closed_form_layout import ENOUGH
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import (
    block_joints_at_bounds,
    column_dot,
    error_squares,
    pose_error,
    solve_damped,
    within_bounds,
)
from ulna.kernels.layout import IN_BASE
from ulna.kernels.spatial.se3 import load_pose

_LEAST_DAMPING = 1e-13


@shared_routine
def polish(chain, target_rows, q_rows, error_rows, bound_rows, inverse_reach, most, steps, jacobian_rows, system_rows, last_rows):
    """At most ``steps`` of the above for the lanes whose error is above ENOUGH and at most ``most``.

    q_rows: (n_dof), changed; error_rows: one, the error (a share of the reach, and radians, in one square), changed; bound_rows:
    the lower bounds of the first joints, then the upper ones, none of the others; the others are scratch: (6 n_dof), (N_SYSTEM),
    (n_dof).
    """
    n_dof, n_bounded, target = q_rows.shape[0], bound_rows.shape[0] // 2, load_pose(target_rows, 0)
    for _ in range(steps):
        error = load(error_rows, 0)
        moving = (error > ENOUGH) & (error <= most)
        if not any_lane(moving):
            return
        e = pose_error(chain_jacobian(chain, q_rows, IN_BASE, jacobian_rows, 6, 1), target)
        p2, r2 = error_squares(e)
        before = sqrt(p2 * inverse_reach**2 + r2)
        block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
        y = solve_damped(jacobian_rows, n_dof, p2 + r2 + _LEAST_DAMPING, e, system_rows)
        for j in range(n_dof):
            q = load(q_rows, j)
            store(last_rows, j, q)
            store(q_rows, j, q + column_dot(jacobian_rows, j, y))
        for j in range(n_bounded):
            store(q_rows, j, within_bounds(load(q_rows, j), bound_rows, j))
        p2, r2 = error_squares(pose_error(chain_pose(chain, q_rows), target))
        after = sqrt(p2 * inverse_reach**2 + r2)
        better = moving & (after < before)
        for j in range(n_dof):
            store(q_rows, j, where(better, load(q_rows, j), load(last_rows, j)))
        store(error_rows, 0, where(better, after, where(moving, before, error)))
