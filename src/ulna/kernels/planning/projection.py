"""Moves configurations towards a constraint, by a step of Levenberg and Marquardt as of inverse kinematics.

Source: the projection of Berenson, Srinivasa and Kuffner, Task space regions (IJRR 2011), with the damped step of
``kernels.ik.levenberg_marquardt`` and the slack of ``kernels.ik.task_error``.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store, where
from ulna.kernels.chain.jacobian import add_joint, clear, express
from ulna.kernels.chain.poses import frame_pose
from ulna.kernels.ik.damped_system import (
    block_joints_at_bounds,
    column_dot,
    error_squares,
    pose_error,
    solve_damped,
    within_bounds,
)
from ulna.kernels.ik.task_error import task_error
from ulna.kernels.layout import IN_BASE, JOINT, PARENT
from ulna.kernels.planning.planning_layout import KEEP_ROWS, PROJECTION, REFERENCE
from ulna.kernels.spatial.se3 import constant_pose, load_pose

_DAMPING, _LEAST_DAMPING = 0.05, 1e-12


@kernel
def project_step(joints, keeps, i, active, q_rows, joint_rows, bound_rows, jacobian_rows, system_rows):
    """Move q by one step towards constraint i, in the lanes that are ``active``, within the bounds.

    1. Of the poses of the joints, take the pose of the constraint's frame and its Jacobian, column by column.
    2. Reduce its error and the Jacobian to what lies beyond the slack of the projection.
    3. dq = J' (J J' + lambda I)^-1 e, lambda in proportion to |e|^2.
    """
    row, like = KEEP_ROWS * i, load(q_rows, 0)
    pose, target = frame_pose(keeps, row, joint_rows, like), constant_pose(keeps, row + REFERENCE, like)
    clear(jacobian_rows, like)
    joint = int(keeps[row, JOINT])
    while joint >= 0:
        add_joint(joints, joint, load_pose(joint_rows, joint), jacobian_rows, 6, 1)
        joint = int(joints[joint, PARENT])
    express(pose, IN_BASE, jacobian_rows, 6, 1)
    e = task_error(keeps[row + PROJECTION], pose, target, pose_error(pose, target), jacobian_rows)
    block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
    p2, r2 = error_squares(e)
    n_dof = jacobian_rows.shape[0] // 6
    y = solve_damped(jacobian_rows, n_dof, (p2 + r2) * _DAMPING + _LEAST_DAMPING, e, system_rows)
    for j in range(n_dof):
        q = load(q_rows, j)
        store(q_rows, j, where(active, within_bounds(q + column_dot(jacobian_rows, j, y), bound_rows, j), q))
