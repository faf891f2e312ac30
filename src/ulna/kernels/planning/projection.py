"""Projects configurations onto a constraint by steps of Levenberg-Marquardt, as in inverse kinematics.

Source: the projection of Berenson, Srinivasa and Kuffner, Task space regions (IJRR 2011), with the damped step of
``kernels.ik.levenberg_marquardt`` and the slack of ``kernels.ik.task_error``.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, sqrt, store, where
from ulna.kernels.chain.jacobian import add_twist, clear, column, express, joint_twist, store_column
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
from ulna.kernels.layout import COLUMN, IN_BASE, JOINT, PARENT
from ulna.kernels.planning.constraint_records import MIN_LENGTH, TOWARDS
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.se3 import load_pose
from ulna.kernels.spatial.vectors import cross, dot, minus, origin, scaled

_DAMPING, _MIN_DAMPING = 0.05, 1e-12
_FLAT = 0.7  # an entry of a unit vector below this bound allows a cross product with its axis


@kernel
def project_step(joints, keeping, i, active, q_rows):
    """Move q by one step towards constraint i, in the ``active`` lanes, within the bounds.

    keeping: the constraints, the poses of the joints, and workspaces (``planning.entries.keeping``).

    1. Compute the poses of the constraint's two frames, and the Jacobian of the first frame relative to the other: the twists of
       the joints that carry only one of the two. If an axis points at the other frame's origin, use the target and the rotation
       of that direction (``facing_pose``).
    2. Reduce the error and the Jacobian to the part beyond the slack of the projection.
    3. Solve dq = J' (J J' + lambda I)^-1 e, with lambda proportional to |e|^2.
    """
    frames, allowed, like = keeping.keeps.frames, keeping.keeps.allowed[i], load(q_rows, 0)
    joint_rows, bound_rows, jacobian_rows = keeping.moving.joint_rows, keeping.bound_rows, keeping.jacobian_rows
    pose, target = frame_pose(frames, 2 * i, joint_rows, like), frame_pose(frames, 2 * i + 1, joint_rows, like)
    clear(jacobian_rows, like)
    add_joints(joints, int(frames[2 * i, JOINT]), allowed.shared, 1.0, joint_rows, jacobian_rows)
    add_joints(joints, int(frames[2 * i + 1, JOINT]), allowed.shared, -1.0, joint_rows, jacobian_rows)
    express(pose, IN_BASE, jacobian_rows, 6, 1)
    if allowed.axes == TOWARDS:
        target = facing_pose(pose, target, jacobian_rows)
    e = task_error(allowed.is_pointing, allowed.slack, pose, target, pose_error(pose, target), jacobian_rows)
    block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
    p2, r2 = error_squares(e)
    n_dof = jacobian_rows.shape[0] // 6
    y = solve_damped(jacobian_rows, n_dof, (p2 + r2) * _DAMPING + _MIN_DAMPING, e, keeping.system_rows)
    for j in range(n_dof):
        q = load(q_rows, j)
        store(q_rows, j, where(active, within_bounds(q + column_dot(jacobian_rows, j, y), bound_rows, j), q))


@kernel
def add_joints(joints, joint, shared, sign, joint_rows, jacobian_rows):
    """Add the twists of a joint and its ancestors below ``shared`` to the Jacobian, times a sign."""
    while joint != shared:
        v, w = joint_twist(joints, joint, load_pose(joint_rows, joint))
        add_twist(jacobian_rows, 6 * int(joints[joint, COLUMN]), 1, scaled(v, sign), scaled(w, sign))
        joint = int(joints[joint, PARENT])


@kernel
def facing_pose(pose, target, jacobian_rows):
    """A pose whose z axis g points from a pose to a target at the distance |d|.

    The rotation of g, v x g / |d|, is subtracted from the Jacobian.
    """
    d = minus(origin(target), origin(pose))
    near = 1.0 / maximum(sqrt(dot(d, d)), MIN_LENGTH)
    g = scaled(d, near)
    for j in range(jacobian_rows.shape[0] // 6):
        v, w = column(jacobian_rows, 6 * j, 1)
        store_column(jacobian_rows, 6 * j, 1, v, minus(w, scaled(cross(v, g), near)))
    flat = abs(g[0]) <= _FLAT
    x = cross((where(flat, 1.0, 0.0), where(flat, 0.0, 1.0), splat(0.0, near)), g)
    x = scaled(x, 1.0 / maximum(sqrt(dot(x, x)), MIN_LENGTH))
    y = cross(g, x)
    return x[0], y[0], g[0], pose[3], x[1], y[1], g[1], pose[7], x[2], y[2], g[2], pose[11]
