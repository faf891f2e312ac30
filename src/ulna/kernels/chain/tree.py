"""Computes the poses of all joints of a tree, and of frames fixed to them. Used by ``posed_pair`` and ``drivers.forward``."""

from ulna.engine.decorators import kernel
from ulna.kernels.chain.joint import joint_pose
from ulna.kernels.layout import AT_JOINT, JOINT, PARENT
from ulna.kernels.spatial.se3 import compose, constant_pose, load_pose, store_pose


@kernel
def tree_poses(joints, q_rows, joint_rows):
    """Write the pose of every joint of the table (parents come before their children) to joint_rows."""
    for i in range(joints.shape[0]):
        pose = joint_pose(joints, i, q_rows)
        parent = int(joints[i, PARENT])
        if parent >= 0:
            pose = compose(load_pose(joint_rows, parent), pose)
        store_pose(joint_rows, i, pose)


@kernel
def frame_pose(frames, k, joint_rows, like):
    """The pose in the base of frame k, which is fixed to its joint."""
    joint = int(frames[k, JOINT])
    if joint < 0:
        return constant_pose(frames, k, like)
    pose = load_pose(joint_rows, joint)
    if frames[k, AT_JOINT] != 0.0:
        return pose
    return compose(pose, constant_pose(frames, k, like))
