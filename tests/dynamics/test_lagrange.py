"""Torques are those of Lagrange's equations, whose energies come from the poses and the Jacobians of the links."""

import numpy as np
import pytest

STEP = 1e-5


def mass_matrix(robot, q):
    """The sum of m Jv' Jv + Jw' T Jw over all links, with the Jacobian of the center of mass."""
    M = np.zeros((robot.n_dof, robot.n_dof))
    for link in robot.description.links:
        T = robot.forward_kinematics(q, link=link.name)
        J = robot.jacobian(q, link=link.name)
        r = T[:3, :3] @ link.inertia.center
        Jv = J[:3] + np.cross(J[3:].T, r).T
        M += link.inertia.mass * Jv.T @ Jv + J[3:].T @ T[:3, :3] @ link.inertia.tensor @ T[:3, :3].T @ J[3:]
    return M


def potential(robot, q):
    """-g . m c, summed over the links that a joint moves."""
    moving = [link for link in robot.description.links if len(robot.tree.moving_columns(link.name))]
    centers = [(robot.forward_kinematics(q, link=link.name) @ [*link.inertia.center, 1.0])[:3] for link in moving]
    return sum(-link.inertia.mass * robot.gravity @ center for link, center in zip(moving, centers, strict=True))


def lagrange(robot, q, qd, qdd):
    """M q'' + M' q' - 1/2 d(q' M q')/dq + dV/dq, by central differences."""
    units = np.eye(robot.n_dof) * STEP
    dM = np.array([(mass_matrix(robot, q + unit) - mass_matrix(robot, q - unit)) / (2 * STEP) for unit in units])
    dV = np.array([(potential(robot, q + unit) - potential(robot, q - unit)) / (2 * STEP) for unit in units])
    return mass_matrix(robot, q) @ qdd + np.tensordot(qd, dM, 1) @ qd - 0.5 * (dM @ qd) @ qd + dV


def test_torques_are_those_of_lagranges_equations(robot, motion):
    torques = robot.inverse_dynamics(*motion)
    for k in range(3):
        assert np.allclose(torques[k], lagrange(robot, *(part[k] for part in motion)), atol=1e-7 * np.abs(torques).max())


def test_the_mass_matrix_is_the_sum_over_the_links(robot, motion):
    q = motion[0]
    assert np.allclose(robot.mass_matrix(q), [mass_matrix(robot, row) for row in q], rtol=0, atol=1e-12)


def test_the_potential_energy_is_the_sum_over_the_links(robot, motion):
    q = motion[0]
    assert np.allclose(robot.potential_energy(q), [potential(robot, row) for row in q], rtol=1e-12)


@pytest.mark.parametrize("which", [0, 1])
def test_derivatives_are_those_of_differences(robot, motion, which):
    derivative = robot.inverse_dynamics_derivatives(*motion)[which]
    for column in range(robot.n_dof):
        step = np.eye(robot.n_dof)[column] * STEP
        after, before = ([*motion[:which], motion[which] + sign * step, *motion[which + 1 :]] for sign in (1, -1))
        by_difference = (robot.inverse_dynamics(*after) - robot.inverse_dynamics(*before)) / (2 * STEP)
        assert np.allclose(derivative[..., column], by_difference, atol=1e-7 * np.abs(derivative).max())
