"""Runs PyTorch Kinematics on the CPU: forward kinematics and Jacobians of batches, in float64.

It is not in the group ``bench``, since PyTorch takes more than five gigabytes: install it by hand. It reads the numbers of a URDF
as float32, so its poses differ by about 1e-8.
"""

import pytorch_kinematics
import torch

from benchmarks.peer import Peer, bare_urdf
from ulna.robot import Robot


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    chain = pytorch_kinematics.build_serial_chain_from_urdf(bare_urdf(robot).encode(), robot.tip, robot.base)
    chain = chain.to(dtype=torch.float64)

    def forward(q):
        return chain.forward_kinematics(torch.from_numpy(q)).get_matrix().numpy()

    def jacobian(q):
        return chain.jacobian(torch.from_numpy(q)).numpy()

    return Peer(forward_batch=forward, jacobian_batch=jacobian)
