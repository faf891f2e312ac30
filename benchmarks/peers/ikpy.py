"""Runs ``ikpy``: forward and inverse kinematics by SciPy, in pure Python; far too slow for thousands of targets."""

import numpy as np
from ikpy.chain import Chain

from benchmarks.peer import NotForThisArm, Peer, bare_urdf, urdf_file
from ulna.robot import Robot


def make(robot: Robot) -> Peer:
    """The peer for an arm: its forward kinematics."""
    with urdf_file(bare_urdf(robot)) as path:
        chain = Chain.from_urdf_file(path, base_elements=[robot.base])
    moving = [k for k, link in enumerate(chain.links) if link.joint_type in ("revolute", "prismatic", "continuous")]
    if [chain.links[k].name for k in moving] != list(robot.joint_names):
        raise NotForThisArm("it reads other joints from the file")

    def own_q(q):
        own = np.zeros(len(chain.links))
        own[moving] = q
        return own

    return Peer(forward=chain.forward_kinematics, own_q=own_q)
