"""Forward kinematics of a whole tree: every joint once, then every frame that stands still relative to a joint."""

import numpy as np

from ulna.kernels.block import all_in_range, gather, scatter_matrix, write_matrix
from ulna.kernels.compile import entry, kernel
from ulna.kernels.joint import joint_pose
from ulna.kernels.kinds import BLOCKS, MATRICES, MATRIX, NUMBERS, TABLE
from ulna.kernels.lanes import WIDTH, load
from ulna.kernels.layout import AT_JOINT, JOINT, PARENT
from ulna.kernels.se3 import compose, constant_pose, load_pose, store_pose


@kernel
def tree_poses(joints, q_rows, joint_rows):
    """Write the pose of every joint of the table (parents stand before their children) to joint_rows."""
    for i in range(joints.shape[0]):
        pose = joint_pose(joints, i, q_rows)
        parent = int(joints[i, PARENT])
        if parent >= 0:
            pose = compose(load_pose(joint_rows, parent), pose)
        store_pose(joint_rows, i, pose)


@kernel
def frame_pose(frames, k, joint_rows, like):
    """The pose in the base of frame k, which stands still relative to its joint."""
    joint = int(frames[k, JOINT])
    if joint < 0:
        return constant_pose(frames, k, like)
    pose = load_pose(joint_rows, joint)
    if frames[k, AT_JOINT] != 0.0:
        return pose
    return compose(pose, constant_pose(frames, k, like))


@entry((TABLE, TABLE, NUMBERS, MATRICES))
def frames_one(joints, frames, q, out):
    """Write the 4x4 matrices of all frames to out, shape (n_frames, 4, 4), for one q. False if q is out of range."""
    joint_rows = np.empty(12 * joints.shape[0])
    tree_poses(joints, q, joint_rows)
    for k in range(frames.shape[0]):
        write_matrix(frame_pose(frames, k, joint_rows, load(q, 0)), out[k])
    return all_in_range(q)


@entry((TABLE, TABLE, MATRIX, BLOCKS))
def frames_batch(joints, frames, q, out):
    """The same for q of shape (n, n_dof), out of shape (n, n_frames, 4, 4): eight rows at a time."""
    q_rows = np.zeros((max(1, q.shape[1]), WIDTH))
    joint_rows = np.empty((12 * joints.shape[0], WIDTH))
    frame_rows = np.empty((12 * frames.shape[0], WIDTH))
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
