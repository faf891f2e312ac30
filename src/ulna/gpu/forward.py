"""Runs forward kinematics and the Jacobian on a GPU."""

from functools import cache

import numpy as np

from ulna.gpu.device import cuda
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose, frame_pose, tree_poses
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kinematics.entries.batch import write_matrix


def poses(chain, q, out, out_of_range):
    """Write T_base_end for q of shape (n, n_dof) to out, shape (n, 4, 4); set the flag if an entry of q is out of range."""
    i = cuda.grid(1)
    if i < q.shape[0]:
        if not all_in_range(q[i]):
            out_of_range[0] = 1
        write_matrix(chain_pose(chain, q[i]), out[i])


def jacobians(chain, expressed_in, q, out, out_of_range):
    """Write J to out, shape (n, 6 n_dof), row after row."""
    i = cuda.grid(1)
    if i < q.shape[0]:
        if not all_in_range(q[i]):
            out_of_range[0] = 1
        chain_jacobian(chain, q[i], expressed_in, out[i], 1, q.shape[1])


@cache
def frames_of(n_joints: int):
    """The driver for robots with so many joints: the poses of all frames, out of shape (n, n_frames, 4, 4)."""
    size = 12 * n_joints

    def frames(joints, table, q, out, out_of_range):
        i = cuda.grid(1)
        if i < q.shape[0]:
            if not all_in_range(q[i]):
                out_of_range[0] = 1
            joint_rows = cuda.local.array(size, np.float64)
            tree_poses(joints, q[i], joint_rows)
            for k in range(table.shape[0]):
                write_matrix(frame_pose(table, k, joint_rows, q[i, 0]), out[i, k])

    return frames
