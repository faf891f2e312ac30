"""Runs forward kinematics and the Jacobian on a GPU."""

from functools import cache
from typing import Any

from ulna.engine.decorators import kernel
from ulna.gpu.staged import MATRIX, over_rows
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose, frame_pose, tree_poses
from ulna.kernels.spatial.elementary import all_in_range


@cache
def poses_of(n_dof: int) -> Any:
    """The driver for robots with n_dof joint positions: T_base_end, rows of 16, by (chain,)."""
    return over_rows(_pose, n_dof, MATRIX)


@cache
def jacobians_of(n_dof: int) -> Any:
    """The driver for robots with n_dof joint positions: J, rows of 6 n_dof, by (chain, expressed_in)."""
    return over_rows(_jacobian, n_dof, 6 * n_dof)


@cache
def frames_of(n_dof: int, n_joints: int, n_frames: int) -> Any:
    """The driver for robots of these sizes: the poses of all frames, rows of 16 n_frames, by (joints, frames)."""
    return over_rows(_frame, n_dof, MATRIX, pieces=n_frames, scratch=12 * n_joints)


@kernel
def _pose(tables, q, _place, _scratch, out, _marks):
    """Write T_base_end for q; returns whether an entry of q is out of range."""
    _write(chain_pose(tables[0], q), out)
    return not all_in_range(q)


@kernel
def _jacobian(tables, q, _place, _scratch, out, _marks):
    """Write J, row after row; returns whether an entry of q is out of range."""
    chain_jacobian(tables[0], q, tables[1], out, 1, q.shape[0])
    return not all_in_range(q)


@kernel
def _frame(tables, q, place, joint_rows, out, _marks):
    """Write the pose of one frame, the first time all joints' poses too; returns whether q is out of range."""
    if place[1] == 0:
        tree_poses(tables[0], q, joint_rows)
    _write(frame_pose(tables[1], place[1], joint_rows, q[0]), out)
    return not all_in_range(q)


@kernel
def _write(pose, out):
    """Write a pose as a homogeneous matrix, row after row."""
    for k in range(12):
        out[k] = pose[k]
    out[12], out[13], out[14], out[15] = 0.0, 0.0, 0.0, 1.0
