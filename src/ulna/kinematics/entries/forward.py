"""Runs forward kinematics over one configuration or a batch."""

import numpy as np

from ulna.engine.decorators import entry, low_latency_entry
from ulna.engine.lanes import WIDTH, empty_rows, load, zero_rows
from ulna.engine.signatures import BLOCKS, MATRICES, MATRIX, NUMBERS, TABLE, WHOLE
from ulna.kernels.chain.poses import chain_pose, frame_pose, joint_turns, tree_poses, turned_chain_pose
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import store_pose
from ulna.kinematics.entries.batch import gather, scatter_matrices, scatter_matrix, share_no_memory, write_matrix


@low_latency_entry((MATRIX, WHOLE, NUMBERS, MATRIX))
def forward_one(chain, n_dof, q, out):
    """Write the 4x4 matrix of the chain's end to out for one q.

    Returns False, and writes nothing, unless q is n_dof numbers in range, and out is 4x4 and shares no memory with q.
    """
    if q.shape[0] != n_dof or out.shape != (4, 4) or not (all_in_range(q) and share_no_memory(q, out)):
        return False
    write_matrix(chain_pose(chain, q), out)
    return True


@entry((TABLE, MATRIX, MATRICES))
def forward_batch(chain, q, out):
    """Write the matrix of the chain's end to out, shape (n, 4, 4), for q of shape (n, n_dof).

    Eight rows are computed at a time. Returns False if q is out of range.
    """
    q_rows, pose_rows = zero_rows(max(1, q.shape[1])), empty_rows(12)
    turn_rows = zero_rows(2 * chain.shape[0])
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        joint_turns(chain, q_rows, turn_rows)
        scatter_matrices(turned_chain_pose(chain, turn_rows), pose_rows, out, start)
    return good


@entry((TABLE, TABLE, NUMBERS, MATRICES))
def frames_one(joints, frames, q, out):
    """Write the matrices of all frames to out, shape (n_frames, 4, 4), for one q; False if out of range."""
    joint_rows = np.empty(12 * joints.shape[0])
    tree_poses(joints, q, joint_rows)
    for k in range(frames.shape[0]):
        write_matrix(frame_pose(frames, k, joint_rows, load(q, 0)), out[k])
    return all_in_range(q)


@entry((TABLE, TABLE, MATRIX, BLOCKS))
def frames_batch(joints, frames, q, out):
    """Write the matrices of all frames to out, shape (n, n_frames, 4, 4), for q of shape (n, n_dof).

    Eight rows of q are computed at a time.
    """
    q_rows = zero_rows(max(1, q.shape[1]))
    joint_rows = empty_rows(12 * joints.shape[0])
    frame_rows = empty_rows(12 * frames.shape[0])
    good = True
    for start in range(0, q.shape[0], WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        tree_poses(joints, q_rows, joint_rows)
        for k in range(frames.shape[0]):
            store_pose(frame_rows, k, frame_pose(frames, k, joint_rows, load(q_rows, 0)))
        for lane in range(WIDTH):
            for k in range(frames.shape[0]):
                scatter_matrix(frame_rows, k, lane, out[min(start + lane, q.shape[0] - 1), k])
    return good
