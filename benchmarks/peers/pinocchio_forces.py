"""Runs Pinocchio's dynamics, by the names of Ulna's methods; also judges motions within torque limits."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from benchmarks.peer import NotForThisArm
from benchmarks.peers.pinocchio import Model
from ulna.robot import Robot

Array = NDArray[np.float64]


class Forces:
    """The dynamics of an arm with limited revolute joints, so that its q is Pinocchio's.

    Attributes:
        calls: By the name of Ulna's method, the function of one q, or of one q and its rates.
        batches: The same for many at once, in one thread, if Pinocchio has such a function.
    """

    def __init__(self, robot: Robot) -> None:
        self.model = Model(robot).model
        if self.model.nq != robot.n_dof or list(self.model.names[1:]) != list(robot.joint_names):
            raise NotForThisArm("its joints have other entries of q than Pinocchio's")
        model, data, self._pool = self.model, self.model.createData(), pin.ModelPool(self.model, 1)
        self.calls: dict[str, Callable] = {
            "inverse_dynamics": lambda x: pin.rnea(model, data, *x),
            "gravity_torque": lambda x: pin.computeGeneralizedGravity(model, data, x[0]),
            "mass_matrix": lambda x: pin.crba(model, data, x[0]),
            "forward_dynamics": lambda x: pin.aba(model, data, *x),
            "inverse_dynamics_derivatives": lambda x: pin.computeRNEADerivatives(model, data, *x),
        }
        self.batches: dict[str, Callable] = {
            "inverse_dynamics": lambda x: pin.rneaInParallel(1, self._pool, *x),
            "forward_dynamics": lambda x: pin.abaInParallel(1, self._pool, *x),
        }

    def torques(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The torques of motions, shape (n, n_dof)."""
        columns = [np.asfortranarray(each.T) for each in (q, qd, qdd)]
        return np.ascontiguousarray(self.batches["inverse_dynamics"](columns).T)
