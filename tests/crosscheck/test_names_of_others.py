"""What docs/conventions.md says of Pinocchio and of Coal is so."""

import coal
import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import Peer

ONE_OF_EACH = """<robot name="r"><link name="base"/><link name="wheel"/><link name="arm"/>
  <joint name="z_first" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
  <joint name="a_second" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""
RPY = np.array([0.3, -0.4, 0.9])


def test_roll_pitch_yaw_are_the_same_and_quaternions_end_with_w():
    R = ulna.pose(rpy=RPY)[:3, :3]
    np.testing.assert_allclose(pin.rpy.rpyToMatrix(*RPY), R, atol=1e-15)
    w, x, y, z = 0.8, 0.1, -0.3, 0.2
    np.testing.assert_array_equal(pin.Quaternion(w, x, y, z).coeffs(), [x, y, z, w])


def test_the_placement_of_a_frame_maps_to_the_world(panda):
    model = pin.buildModelFromXML(panda.to_urdf())
    data = model.createData()
    pin.framesForwardKinematics(model, data, panda.home)
    placement = data.oMf[model.getFrameId("panda_ee")]
    np.testing.assert_allclose(placement.homogeneous, panda.forward_kinematics(panda.home), atol=1e-12)


def test_twists_are_linear_first():
    np.testing.assert_array_equal(pin.Motion(np.array([1.0, 2, 3]), np.array([4.0, 5, 6])).vector, [1, 2, 3, 4, 5, 6])


def test_q_has_a_cosine_and_a_sine_for_a_continuous_joint_and_its_own_order():
    robot, model = ulna.load(ONE_OF_EACH), pin.buildModelFromXML(ONE_OF_EACH)
    assert robot.joint_names == ("z_first", "a_second")  # as in the file
    assert list(model.names)[1:] == ["a_second", "z_first"]  # by the alphabet
    assert (robot.n_dof, model.nq, model.nv) == (2, 3, 2)
    np.testing.assert_allclose(Peer(robot, model).configuration(np.array([0.5, 0.2])), [0.2, np.cos(0.5), np.sin(0.5)])


def test_a_floating_base_is_x_y_z_and_a_quaternion_with_w_last():
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    np.testing.assert_array_equal(pin.neutral(model), [0, 0, 0, 0, 0, 0, 1])


def test_coals_lengths_are_whole_and_a_capsules_is_without_its_ends():
    np.testing.assert_allclose(coal.Box(0.1, 0.2, 0.3).halfSide, [0.05, 0.1, 0.15])
    assert coal.Cylinder(0.1, 0.8).halfLength == coal.Capsule(0.1, 0.8).halfLength == 0.4
    capsule = coal.Capsule(0.1, 0.8)
    capsule.computeLocalAABB()
    np.testing.assert_allclose(capsule.aabb_local.max_, [0.1, 0.1, 0.5])


@pytest.mark.parametrize("apart", [0.05, -0.05])
def test_coals_distances_are_negative_inside_and_the_normal_points_from_the_first(apart):
    here, there = coal.Transform3s.Identity(), coal.Transform3s.Identity()
    there.setTranslation(np.array([0.2 + apart, 0, 0]))
    result = coal.DistanceResult()
    distance = coal.distance(coal.Sphere(0.1), here, coal.Sphere(0.1), there, coal.DistanceRequest(), result)
    assert distance == pytest.approx(apart)
    np.testing.assert_allclose(result.normal, [1, 0, 0], atol=1e-12)


def test_what_pinocchio_calls_the_torques_of_a_motion_and_its_parts(panda, rng):
    model = pin.buildModelFromXML(panda.to_urdf())
    data = model.createData()
    np.testing.assert_array_equal(model.gravity.linear, panda.gravity)
    q, (qd, qdd) = panda.random(seed=1), rng.normal(size=(2, 7))
    torque = panda.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(pin.rnea(model, data, q, qd, qdd), torque, atol=1e-10)
    np.testing.assert_allclose(pin.computeGeneralizedGravity(model, data, q), panda.gravity_torque(q), atol=1e-10)
    np.testing.assert_allclose(pin.computeCoriolisMatrix(model, data, q, qd) @ qd, panda.coriolis_torque(q, qd), atol=1e-10)
    np.testing.assert_allclose(np.triu(pin.crba(model, data, q)), np.triu(panda.mass_matrix(q)), atol=1e-10)
    np.testing.assert_allclose(pin.aba(model, data, q, qd, torque), panda.forward_dynamics(q, qd, torque), atol=1e-8)
