"""Runs Pinocchio (``pin``): forward kinematics and Jacobians; also judges every solver's results."""

import numpy as np
import pinocchio as pin

from benchmarks.peer import Peer, bare_urdf
from ulna.robot import Robot


class Model:
    """A Pinocchio model of an arm. A continuous joint is (cos, sin) in its q."""

    def __init__(self, robot: Robot) -> None:
        self.model = pin.buildModelFromXML(bare_urdf(robot))
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(robot.tip)
        self.placement = self.data.oMf[self.frame]
        order = [robot.joint_names.index(name) for name in self.model.names[1:]]
        self.entries = [(joint.idx_q, joint.nq, k) for joint, k in zip(list(self.model.joints)[1:], order, strict=True)]

    def own_q(self, q):
        """Pinocchio's q for Ulna's."""
        own = np.empty(self.model.nq)
        for start, width, k in self.entries:
            own[start : start + width] = (np.cos(q[k]), np.sin(q[k])) if width == 2 else q[k]
        return own

    def forward(self, q):
        """The tip's pose as a 4x4 matrix."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.frame].homogeneous

    def forward_kept(self, q):
        """The same, without fetching the placement, which costs half as much as computing it."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.placement.homogeneous

    def jacobian(self, q):
        """The tip's Jacobian, in the axes of the base."""
        return pin.computeFrameJacobian(self.model, self.data, q, self.frame, pin.LOCAL_WORLD_ALIGNED)

    def forward_all(self, q):
        """The tip's poses, shape (n, 4, 4), for Ulna's q, shape (n, n_dof)."""
        return np.array([self.forward(self.own_q(x)) for x in q])


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    model = Model(robot)
    return Peer(forward=model.forward, forward_kept=model.forward_kept, jacobian=model.jacobian, own_q=model.own_q)
