"""Forward kinematics of one link: the product of the joint poses from the base to it."""

import numpy as np

from ulna.kernels.block import all_in_range, gather, scatter_matrix, write_matrix
from ulna.kernels.compile import brief_entry, entry, kernel
from ulna.kernels.joint import joint_pose
from ulna.kernels.kinds import MATRICES, MATRIX, NUMBERS, TABLE, WHOLE
from ulna.kernels.lanes import WIDTH
from ulna.kernels.memory import apart
from ulna.kernels.se3 import compose, store_pose


@kernel
def chain_pose(chain, q_rows):
    """The pose of a chain's end: T_base_end = T_base_1(q) T_1_2(q) ... T_n_end."""
    pose = joint_pose(chain, 0, q_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, joint_pose(chain, i, q_rows))
    return pose


@brief_entry((MATRIX, WHOLE, NUMBERS, MATRIX))
def forward_one(chain, n_dof, q, out):
    """Write the 4x4 matrix of the chain's end to out for one q.

    False, and nothing is written, if q is not n_dof numbers in range, or out is not 4x4, or shares memory with q.
    """
    if q.shape[0] != n_dof or out.shape != (4, 4) or not (all_in_range(q) and apart(q, out)):
        return False
    write_matrix(chain_pose(chain, q), out)
    return True


@entry((TABLE, MATRIX, MATRICES))
def forward_batch(chain, q, out):
    """The same for q of shape (n, n_dof), out of shape (n, 4, 4): eight rows at a time."""
    q_rows, pose_rows = np.zeros((max(1, q.shape[1]), WIDTH)), np.empty((12, WIDTH))
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        store_pose(pose_rows, 0, chain_pose(chain, q_rows))
        for lane in range(WIDTH):
            scatter_matrix(pose_rows, 0, lane, out[min(start + lane, q.shape[0] - 1)])
    return good
