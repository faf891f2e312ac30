"""Compares dynamics with Pinocchio."""

import numpy as np
import pinocchio as pin

import ulna
from pinocchio_peer import Peer, random_positions

NOTHING = ulna.Inertia(0.0, np.zeros(3), np.zeros((3, 3)))


def with_all_inertias(robot: ulna.Robot) -> ulna.Robot:
    """The robot with an inertia of zero for each link that has none, as Pinocchio takes it."""
    return robot.with_inertias({link.name: NOTHING for link in robot.description.links if link.inertia is None})


def differences(peer: Peer, n: int = 20) -> dict[str, float]:
    """By method, the largest difference from Pinocchio over n random motions, as a share of the largest number there or of 1."""
    robot, model, data, R = peer.robot, peer.model, peer.data, peer.rates()
    q = random_positions(robot, n)
    qd, qdd = np.random.default_rng(2).normal(size=(2, *q.shape))
    torque = robot.inverse_dynamics(q, qd, qdd)
    by_q, by_rate = robot.inverse_dynamics_derivatives(q, qd, qdd)
    ours = {
        "inverse_dynamics": torque,
        "gravity_torque": robot.gravity_torque(q),
        "coriolis_torque": robot.coriolis_torque(q, qd),
        "mass_matrix": robot.mass_matrix(q),
        "derivative by q": by_q,
        "derivative by qd": by_rate,
        "center_of_mass": robot.center_of_mass(q),
        "center_of_mass_jacobian": robot.center_of_mass_jacobian(q),
        "kinetic_energy": robot.kinetic_energy(q, qd),
        "potential_energy": robot.potential_energy(q),
    }
    largest = dict.fromkeys(ours, 0.0)
    for k in range(n):
        x, v, a = peer.configuration(q[k]), R @ qd[k], R @ qdd[k]
        theirs = {
            "inverse_dynamics": R.T @ pin.rnea(model, data, x, v, a),
            "gravity_torque": R.T @ pin.computeGeneralizedGravity(model, data, x),
            "coriolis_torque": R.T @ (pin.nonLinearEffects(model, data, x, v) - pin.computeGeneralizedGravity(model, data, x)),
            "mass_matrix": R.T @ whole(pin.crba(model, data, x)) @ R,
        }
        derivatives = pin.computeRNEADerivatives(model, data, x, v, a)
        theirs |= {"derivative by q": R.T @ derivatives[0] @ R, "derivative by qd": R.T @ derivatives[1] @ R}
        theirs |= {
            "center_of_mass": pin.centerOfMass(model, data, x),
            "center_of_mass_jacobian": pin.jacobianCenterOfMass(model, data, x) @ R,
        }
        theirs |= {
            "kinetic_energy": pin.computeKineticEnergy(model, data, x, v),
            "potential_energy": pin.computePotentialEnergy(model, data, x),
        }
        for name, value in theirs.items():
            share = np.abs(ours[name][k] - value).max() / max(1.0, np.abs(value).max())
            largest[name] = max(largest[name], share)
    return largest


def whole(upper: np.ndarray) -> np.ndarray:
    """A symmetric matrix of its upper triangle, which is all that Pinocchio writes."""
    return np.triu(upper) + np.triu(upper, 1).T
