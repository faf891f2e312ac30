"""What holds for the dynamics of every robot."""

import copy

import numpy as np
import pytest

import ulna


def test_torques_are_linear_in_accelerations_by_the_mass_matrix(robot, motion):
    q, qd, qdd = motion
    apart = np.einsum("nij,nj->ni", robot.mass_matrix(q), qdd) + robot.coriolis_torque(q, qd) + robot.gravity_torque(q)
    assert np.allclose(robot.inverse_dynamics(q, qd, qdd), apart, rtol=1e-12, atol=1e-12 * np.abs(apart).max())


def test_the_mass_matrix_is_symmetric_and_positive_definite(robot, motion):
    M = robot.mass_matrix(motion[0])
    assert np.array_equal(M, np.swapaxes(M, -1, -2))
    assert np.linalg.eigvalsh(M).min() > 0


def test_forward_dynamics_inverts_inverse_dynamics(robot, motion):
    q, qd, qdd = motion
    wrenches = {robot.tree.leaves[-1]: np.random.default_rng(5).normal(size=(len(q), 6))}
    torque = robot.inverse_dynamics(q, qd, qdd, wrenches=wrenches, gravity=(1, 2, 3))
    assert np.allclose(robot.forward_dynamics(q, qd, torque, wrenches=wrenches, gravity=(1, 2, 3)), qdd, atol=1e-9)


def test_power_is_the_rate_of_the_energy(robot, motion):
    """d/dt (kinetic + potential) = qd . tau, for q(t) = q + qd t + qdd t^2 / 2."""
    q, qd, qdd = motion
    step = 1e-6

    def energy(t):
        at = q + qd * t + qdd * t * t / 2
        return robot.kinetic_energy(at, qd + qdd * t) + robot.potential_energy(at)

    power = (robot.inverse_dynamics(q, qd, qdd) * qd).sum(-1)
    assert np.allclose((energy(step) - energy(-step)) / (2 * step), power, rtol=1e-6, atol=1e-6)


def test_gravity_torque_is_the_gradient_of_the_potential_energy(robot, motion):
    q = motion[0]
    step = 1e-6 * np.eye(robot.n_dof)
    slope = [(robot.potential_energy(q + one) - robot.potential_energy(q - one)) / 2e-6 for one in step]
    assert np.allclose(np.transpose(slope), robot.gravity_torque(q), atol=1e-6)


def test_the_center_of_mass_moves_by_its_jacobian(robot, motion):
    q = motion[0]
    step = 1e-6 * np.eye(robot.n_dof)
    slopes = [(robot.center_of_mass(q + one) - robot.center_of_mass(q - one)) / 2e-6 for one in step]
    assert np.allclose(np.moveaxis(slopes, 0, -1), robot.center_of_mass_jacobian(q), atol=1e-8)


def test_torques_are_the_regressor_times_the_inertial_parameters(robot, motion):
    torque = np.einsum("nijk,jk->ni", robot.regressor(*motion), robot.inertial_parameters)
    assert np.allclose(torque, robot.inverse_dynamics(*motion), atol=1e-11 * np.abs(torque).max())


def test_a_wrench_takes_its_transposed_jacobian_off_the_torques(robot, motion):
    q, link, wrench = motion[0], robot.tree.leaves[0], np.arange(6.0)
    less = robot.inverse_dynamics(*motion) - robot.inverse_dynamics(*motion, wrenches={link: wrench})
    assert np.allclose(less, robot.jacobian(q, link=link).swapaxes(-1, -2) @ wrench, atol=1e-9)
    measured = robot.inverse_dynamics(*motion, wrenches={link: wrench})
    assert np.allclose(robot.external_torque(*motion, measured), -less, atol=1e-9)


def test_the_operational_inertia_gives_the_acceleration_that_a_force_causes():
    random = np.random.default_rng(3)
    arm = ulna.load("panda")
    arm = arm.with_inertias({link: ulna.Inertia(1.0, random.normal(size=3) / 9, np.eye(3) / 50) for link in arm.link_names})
    q, zero, force = arm.random(seed=4), np.zeros(7), np.array([3.0, -2.0, 1.0, 0.3, 0.1, -0.2])
    qdd = arm.forward_dynamics(q, zero, zero, wrenches={arm.tip: force}, gravity=(0, 0, 0))
    assert np.allclose(arm.operational_inertia(q) @ arm.jacobian(q) @ qdd, force)


def test_a_row_of_a_batch_has_the_same_bits_alone(robot, motion):
    q, qd, qdd = motion
    for batch, single in (
        (robot.inverse_dynamics(q, qd, qdd), lambda k: robot.inverse_dynamics(q[k], qd[k], qdd[k])),
        (robot.gravity_torque(q), lambda k: robot.gravity_torque(q[k])),
        (robot.mass_matrix(q), lambda k: robot.mass_matrix(q[k])),
        (robot.forward_dynamics(q, qd, qdd), lambda k: robot.forward_dynamics(q[k], qd[k], qdd[k])),
        (robot.inverse_dynamics_derivatives(q, qd, qdd)[0], lambda k: robot.inverse_dynamics_derivatives(q[k], qd[k], qdd[k])[0]),
    ):
        assert all(np.array_equal(batch[k], single(k)) for k in (0, 7, 8, 18))


def test_batches_are_broadcast_and_out_is_filled(robot, motion):
    q, qd, _ = motion
    out = np.empty((4, 19, robot.n_dof))
    qdd = np.arange(4.0)[:, None, None]
    torque = robot.inverse_dynamics(q, qd[3], qdd * np.ones(robot.n_dof), out=out)
    assert torque is out
    assert np.array_equal(out[2, 5], robot.inverse_dynamics(q[5], qd[3], np.full(robot.n_dof, 2.0)))


def test_derivatives_are_written_to_one_array(robot, motion):
    out = np.full((2, 19, robot.n_dof, robot.n_dof), np.nan)
    by_q, by_rate = robot.inverse_dynamics_derivatives(*motion, out=out)
    assert np.shares_memory(by_q, out[0])
    assert np.shares_memory(by_rate, out[1])
    assert np.array_equal(out, robot.inverse_dynamics_derivatives(*motion))
    with pytest.raises(ulna.InputError, match=r"out: float64 of shape \(19, .*of shape \(2, 19, "):
        robot.inverse_dynamics_derivatives(*motion, out=out[0])


def test_gravity_turns_with_the_mounting(robot, motion):
    q = motion[0]
    turned = robot.with_gravity((3.0, -9.0, 1.0))
    assert np.array_equal(turned.gravity_torque(q), robot.gravity_torque(q, gravity=(3.0, -9.0, 1.0)))
    assert np.array_equal(copy.deepcopy(turned).gravity_torque(q), turned.gravity_torque(q))
    held = turned.with_attached("ball", ulna.Sphere(0.1), np.eye(4), link=robot.link_names[-1])
    assert np.array_equal(held.gravity, turned.gravity)
    lifted = robot.inverse_dynamics(q, np.zeros(robot.n_dof), np.zeros(robot.n_dof), gravity=(3.0, -9.0, 1.0))
    assert np.allclose(lifted, turned.gravity_torque(q), atol=1e-10)


def test_two_links_of_the_textbook():
    """Siciliano et al., Robotics (2009), equation 7.82: an arm of two links in a vertical plane, without motors."""
    a1, l1, l2, m1, m2, I1, I2, g = 1.0, 0.5, 0.4, 3.0, 2.0, 0.3, 0.2, 9.81
    arm = ulna.Robot.from_dh([(0, 0, 0, 0), (a1, 0, 0, 0)]).with_gravity((0, -g, 0))
    tensors = np.diag([0, 0, I1]), np.diag([0, 0, I2])
    arm = arm.with_inertias(
        {"link1": ulna.Inertia(m1, (l1, 0, 0), tensors[0]), "link2": ulna.Inertia(m2, (l2, 0, 0), tensors[1])}
    )
    q, (v1, v2) = np.array([0.7, -1.1]), (0.9, -0.4)
    c2, s2, c1, c12 = np.cos(q[1]), np.sin(q[1]), np.cos(q[0]), np.cos(q.sum())
    b12 = I2 + m2 * (l2**2 + a1 * l2 * c2)
    M = [[I1 + m1 * l1**2 + I2 + m2 * (a1**2 + l2**2 + 2 * a1 * l2 * c2), b12], [b12, I2 + m2 * l2**2]]
    h = -m2 * a1 * l2 * s2
    assert np.allclose(arm.mass_matrix(q), M, rtol=1e-14)
    assert np.allclose(arm.coriolis_torque(q, (v1, v2)), [h * v2 * v2 + 2 * h * v1 * v2, -h * v1 * v1], rtol=1e-13)
    assert np.allclose(arm.gravity_torque(q), [(m1 * l1 + m2 * a1) * g * c1 + m2 * l2 * g * c12, m2 * l2 * g * c12], rtol=1e-14)


@pytest.mark.parametrize("threads", [1, 2])
def test_many_rows_have_the_same_bits_with_every_number_of_threads(robot, threads):
    q = robot.random(5000, seed=2)
    with ulna.threads(threads):
        torque = robot.gravity_torque(q)
    assert np.array_equal(torque[::777], [robot.gravity_torque(row) for row in q[::777]])
