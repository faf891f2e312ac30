"""Computes the pose of one link, the product of its joint poses. Used by ``drivers.forward`` and ``drivers.single_start``."""

from ulna.engine.decorators import kernel
from ulna.kernels.chain.joint import joint_pose
from ulna.kernels.spatial.se3 import compose


@kernel
def chain_pose(chain, q_rows):
    """The pose of a chain's end: T_base_end = T_base_1(q) T_1_2(q) ... T_n_end."""
    pose = joint_pose(chain, 0, q_rows)
    for i in range(1, chain.shape[0]):
        pose = compose(pose, joint_pose(chain, i, q_rows))
    return pose
