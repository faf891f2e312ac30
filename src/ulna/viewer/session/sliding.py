"""Changes a step of the joints so that it ends free of collision: the arm slides along obstacles.

Source: Faverjon and Tournassoud, A local based approach for path planning of manipulators with a high number of degrees of
freedom (IEEE Int. Conf. Robotics and Automation 1987): the distance of a near pair is linear in a small step.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.collision.report import Pair
from ulna.collision.world import World
from ulna.robot import Robot

NEAR, MARGIN = 0.03, 1e-3  # [m] the distance up to which pairs are considered, and the distance that is kept
_OUT = 1e-3  # [m] by which a step increases the distance of a pair that is nearer than MARGIN
_MOST_PAIRS, _SWEEPS = 12, 60
_DAMPING = 1e-3  # of the metric: J'J + _DAMPING I
Array = NDArray[np.float64]


def along_contacts(robot: Robot, q: Array, change: Array, link: str, world: World) -> tuple[Array, tuple[Pair, ...]]:
    """The step nearest to a wanted one, measured by the motion of the link, that brings no pair nearer than MARGIN.

    Args:
        robot: The robot.
        q: Joint positions [rad or m], shape (n_dof,).
        change: The wanted step, shape (n_dof,); its zero entries stay zero.
        link: The link whose motion is kept as far as possible.
        world: The obstacles; self-collision is avoided too.

    Returns:
        The step, shape (n_dof,), and the pairs because of which it differs from the wanted one.
    """
    pairs = robot.check_collision(q, world, max_distance=NEAR).pairs[:_MOST_PAIRS]
    free = np.flatnonzero(change)
    if not pairs or not free.size:
        return change, ()
    rates = np.array([_rate(robot, q, pair) for pair in pairs])[:, free]
    least = np.minimum(MARGIN - np.array([pair.signed_distance for pair in pairs]), _OUT)
    J = robot.jacobian(q, link=link)[:, free]
    step, forces = _nearest_step(J.T @ J + _DAMPING * np.eye(free.size), change[free], rates, least)
    slid = np.zeros_like(change)
    slid[free] = step
    return slid, tuple(pair for pair, force in zip(pairs, forces, strict=True) if force > 0.0)


def _rate(robot: Robot, q: Array, pair: Pair) -> Array:
    """The gradient of a pair's distance in q, shape (n_dof,): the rate at which its nearest points separate along the normal."""
    rate = -pair.normal @ _point_jacobian(robot, q, pair.link_a, pair.witness_a)
    if pair.link_b is not None:
        rate += pair.normal @ _point_jacobian(robot, q, pair.link_b, pair.witness_b)
    return rate


def _point_jacobian(robot: Robot, q: Array, link: str, point: Array) -> Array:
    """The Jacobian of a point [m] that moves with a link, or with an object attached to one, shape (3, n_dof)."""
    carrier = next((held.link for held in robot.attached if held.name == link), link)
    J = robot.jacobian(q, link=carrier)
    return J[:3] + np.cross(J[3:], point - robot.forward_kinematics(q, link=carrier)[:3, 3], axis=0)


def _nearest_step(H: Array, wanted: Array, G: Array, least: Array) -> tuple[Array, Array]:
    """The x nearest to a wanted one in the metric H with G x >= least, and the multipliers; by Gauss-Seidel in the dual."""
    HG = np.linalg.solve(H, G.T)
    W, lack = G @ HG, least - G @ wanted
    forces = np.zeros(len(G))
    for _ in range(_SWEEPS):
        before = forces.copy()
        for k in np.flatnonzero(np.diag(W) > 1e-12):
            forces[k] = max(0.0, forces[k] + (lack[k] - W[k] @ forces) / W[k, k])
        if np.abs(forces - before).max() <= 1e-9 * max(1.0, forces.max()):
            break
    return wanted + HG @ forces, forces
