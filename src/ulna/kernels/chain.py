"""Forward kinematics of one link: the product of the joint poses from the base to it."""

import numpy as np

from ulna.kernels.block import all_in_range, gather, scatter_matrix, write_matrix
from ulna.kernels.compile import entry, kernel
from ulna.kernels.joint import joint_pose
from ulna.kernels.lanes import WIDTH
from ulna.kernels.se3 import compose, store_pose


@kernel
def chain_pose(chain, q_rows):
    """The pose of a chain's end: T_base_end = T_base_1(q) T_1_2(q) ... T_n_end."""
    pose = joint_pose(chain, 0, q_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, joint_pose(chain, i, q_rows))
    return pose


@entry
def forward_one(chain, q, out):
    """Write the 4x4 matrix of the chain's end to out for one q. False if an entry of q is out of range."""
    write_matrix(chain_pose(chain, q), out)
    return all_in_range(q)


@entry
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
