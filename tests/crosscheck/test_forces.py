"""Torques, mass matrices and what is derived from them are Pinocchio's, for every robot of example-robot-data.

Pinocchio's dynamics know no mimic: there every joint has an entry of q, and the peer makes mimics follow.
"""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_forces import differences, with_all_inertias
from pinocchio_peer import Peer
from robot_files import example_urdfs, of_kinds

# Two are not loaded (test_every_urdf says why), and two have no joint.
LEFT_OUT = {"alex_psyonic_hands", "ur3", "quadrotor_base", "iris_simple"}
FILES = [file for file in example_urdfs() if file.stem not in LEFT_OUT]


@pytest.mark.parametrize("file", of_kinds(FILES), ids=lambda file: file.stem)
def test_a_robot_of_example_robot_data(file):
    robot = with_all_inertias(ulna.load(file))
    worst = differences(Peer(robot, pin.buildModelFromUrdf(str(file))))
    assert max(worst.values()) < 1e-10, worst


@pytest.mark.parametrize("name", ["panda", "fr3", "ur10e", "xarm7"])
def test_a_robot_by_its_name_as_it_is_written(name):
    robot = ulna.load(name)
    worst = differences(Peer(robot, pin.buildModelFromXML(robot.to_urdf())))
    assert max(worst.values()) < 1e-10, worst


def test_a_payload_is_that_of_a_link_fixed_to_the_arm(panda):
    held = panda.with_attached("part", ulna.Box((0.1, 0.2, 0.3)), ulna.pose((0.01, 0.02, 0.1), rpy=(1, 2, 3)), mass=2.5)
    model = pin.buildModelFromXML(panda.to_urdf())
    frame = model.frames[model.getFrameId(panda.tip, pin.FrameType.BODY)]
    place = frame.placement * pin.SE3(held.attached[0].T_link_object)
    model.appendBodyToJoint(frame.parentJoint, pin.Inertia.FromBox(2.5, 0.1, 0.2, 0.3), place)
    worst = differences(Peer(held, model))
    assert max(worst.values()) < 1e-10, worst


def test_accelerations_are_those_of_articulated_bodies():
    """Pinocchio's algorithm is Featherstone's of articulated bodies; here the mass matrix is factored."""
    robot = ulna.load("ur10e")
    peer = Peer(robot, pin.buildModelFromXML(robot.to_urdf()))
    q, (qd, torque) = robot.random(50, seed=3), np.random.default_rng(4).normal(size=(2, 50, 6))
    ours = robot.forward_dynamics(q, qd, torque)
    theirs = [pin.aba(peer.model, peer.data, *row) for row in zip(q, qd, torque, strict=True)]
    assert np.allclose(ours, theirs, rtol=1e-9, atol=1e-9)


def test_the_bodies_of_the_regressor_are_the_joints_of_pinocchio():
    """Its parameters are the mass, the moment, and xx, xy, yy, xz, yz, zz of the tensor."""
    robot = ulna.load("ur5e")
    peer = Peer(robot, pin.buildModelFromXML(robot.to_urdf()))
    q, (qd, qdd) = robot.random(seed=5), np.random.default_rng(6).normal(size=(2, 6))
    theirs = pin.computeJointTorqueRegressor(peer.model, peer.data, q, qd, qdd)
    parameters = np.concatenate([inertia.toDynamicParameters() for inertia in list(peer.model.inertias)[1:]])
    ours = np.einsum("ijk,jk->i", robot.regressor(q, qd, qdd), robot.inertial_parameters)
    assert np.allclose(ours, theirs @ parameters, atol=1e-11)
    assert np.allclose(robot.inertial_parameters[:, 0], [inertia.mass for inertia in list(peer.model.inertias)[1:]])
