"""Forward kinematics and Jacobians of the Panda, and of planar and floating joints, against Pinocchio (pin)."""

import numpy as np
import pinocchio as pin
import pytest

import ulna
from pinocchio_peer import FRAMES, Peer, random_positions

PLANAR_AND_FLOATING = """<robot name="raft">
  <link name="sea"/><link name="raft"/><link name="bird"/><link name="beak"/>
  <joint name="drift" type="planar">
    <parent link="sea"/><child link="raft"/><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="flight" type="floating"><parent link="raft"/><child link="bird"/><origin xyz="0 0.5 0" rpy="0.1 -0.2 1.3"/></joint>
  <joint name="nod" type="continuous">
    <parent link="bird"/><child link="beak"/><origin xyz="0.2 0 0"/><axis xyz="1 2 -2"/>
  </joint>
</robot>"""


@pytest.fixture(scope="module")
def panda_peer(panda):
    return Peer(panda, pin.buildModelFromXML(panda.to_urdf()))


def test_the_panda_is_where_pinocchio_puts_it_in_every_link(panda, panda_peer):
    q = np.vstack([panda.home, np.zeros(7), panda.lower, panda.upper, random_positions(panda, 100)])
    expected = np.array([panda_peer.link_poses(row) for row in q])
    np.testing.assert_allclose(panda.link_poses(q), expected, rtol=0, atol=1e-12)
    one_by_one = np.array([panda.link_poses(row) for row in q])
    np.testing.assert_allclose(one_by_one, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("expressed_in", FRAMES)
@pytest.mark.parametrize("link", ["panda_link1", "panda_link4", "panda_link8", "panda_ee"])
def test_a_jacobian_of_the_panda_is_pinocchios_in_each_of_its_frames(panda, panda_peer, link, expressed_in):
    q = np.vstack([panda.home, np.zeros(7), random_positions(panda, 100)])
    expected = np.array([panda_peer.jacobian(row, link, expressed_in) for row in q])
    np.testing.assert_allclose(panda.jacobian(q, link=link, expressed_in=expressed_in), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(panda.jacobian(q[3], link=link, expressed_in=expressed_in), expected[3], rtol=0, atol=1e-12)


def test_the_three_frames_of_a_jacobian_are_three_different_things(panda):
    J = [panda.jacobian(panda.home, expressed_in=name) for name in FRAMES]
    assert min(np.abs(J[i] - J[k]).max() for i, k in ((0, 1), (0, 2), (1, 2))) > 0.1


def test_planar_and_floating_joints_stand_where_pinocchio_puts_them():
    robot = ulna.load(PLANAR_AND_FLOATING)
    peer = Peer(robot, pin.buildModelFromXML(PLANAR_AND_FLOATING))
    assert robot.joint_slices == (slice(0, 3), slice(3, 9), slice(9, 10))
    for q in random_positions(robot, 50):
        np.testing.assert_allclose(robot.link_poses(q), peer.link_poses(q), rtol=0, atol=1e-12)


def test_a_quaternion_of_urdf_1_1_is_read_as_pinocchio_reads_it(rng):
    text = """<robot name="r" version="1.1"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>
    <child link="b"/><origin xyz="1 2 3" quat_xyzw="{}"/><axis xyz="0 1 0"/></joint></robot>"""
    for xyzw in rng.normal(size=(20, 4)):
        urdf = text.format(" ".join(map(repr, xyzw.tolist())))
        model = pin.buildModelFromXML(urdf)
        data = model.createData()
        pin.framesForwardKinematics(model, data, pin.neutral(model))
        assert np.abs(ulna.load(urdf).forward_kinematics([0.0]) - data.oMf[model.getFrameId("b")].homogeneous).max() < 1e-14
