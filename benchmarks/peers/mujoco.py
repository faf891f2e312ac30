"""Runs MuJoCo: forward kinematics and Jacobians of the compiled model, with the tip marked by a site."""

import mujoco
import numpy as np
from mujoco.batch import Batch

from benchmarks.peer import Peer, bare_urdf
from ulna.robot import Robot


class Model:
    """A MuJoCo model of an arm, with a mass for every body, which its compiler requires."""

    def __init__(self, robot: Robot) -> None:
        spec = mujoco.MjSpec.from_string(bare_urdf(robot))
        spec.compiler.fusestatic = False
        spec.compiler.boundmass = spec.compiler.boundinertia = 1e-3
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.body = self.model.body(robot.tip).id
        self.position, self.turn = self.data.xpos[self.body], self.data.xmat[self.body].reshape(3, 3)
        names = [self.model.joint(k).name for k in range(self.model.njnt)]
        self.order = np.array([robot.joint_names.index(name) for name in names])
        self.batch = None

    def forward(self, q):
        """The tip's pose as a 4x4 matrix."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.turn, self.position
        return T

    def jacobian(self, q):
        """The tip's Jacobian, in the axes of the base."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        J = np.empty((6, self.model.nv))
        mujoco.mj_jacBody(self.model, self.data, J[:3], J[3:], self.body)
        return J

    def forward_batch(self, q):
        """The tip's poses of many q, shape (n, 4, 4), in one call and one thread."""
        batch = self._batch_of(q)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        T = np.zeros((len(q), 4, 4))
        T[:, :3, :3] = batch.bind("xmat")[:, self.body].reshape(-1, 3, 3)
        T[:, :3, 3], T[:, 3, 3] = batch.bind("xpos")[:, self.body], 1.0
        return T

    def jacobian_batch(self, q):
        """The tip's Jacobians of many q, shape (n, 6, n_dof), in one call after the poses."""
        batch = self._batch_of(q)
        batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS.value)
        return np.concatenate(batch.jac(self.body, batch.bind("xpos")[:, self.body]), axis=1)

    def _batch_of(self, q):
        """The states of many q."""
        if self.batch is None or self.batch.nsim != len(q):
            self.batch = Batch(self.model, len(q), nthread=1)
            self.batch.bind("xmat"), self.batch.bind("xpos")
        self.batch.bind("qpos")[:] = q[:, self.order]
        return self.batch


def make(robot: Robot) -> Peer:
    """The peer for an arm."""
    model = Model(robot)
    return Peer(
        forward=model.forward, jacobian=model.jacobian, own_q=lambda q: q[model.order],
        forward_batch=model.forward_batch, jacobian_batch=model.jacobian_batch,
    )  # fmt: skip
