"""Where the robot's bodies stand at q."""

from ulna.kernels.compile import kernel
from ulna.kernels.lanes import load
from ulna.kernels.se3 import store_pose
from ulna.kernels.tree import frame_pose, tree_poses


@kernel
def place_bodies(joints, bodies, q_rows, joint_rows, body_rows):
    """Write the pose of every body of the robot to body_rows."""
    tree_poses(joints, q_rows, joint_rows)
    for k in range(bodies.shape[0]):
        store_pose(body_rows, k, frame_pose(bodies, k, joint_rows, load(q_rows, 0)))
