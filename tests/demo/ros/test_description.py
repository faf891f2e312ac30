"""The description for robot_state_publisher, without ROS: it has every published joint, and the arm is unchanged."""

import numpy as np
from lxml import etree

import ulna
from ulna.demo.drawing import joint_positions
from ulna.demo.ros.description import with_fingers
from ulna.description.pose import pose


def load_description(panda):
    return ulna.load(with_fingers(panda.to_urdf()))


def test_the_description_has_exactly_the_published_joints(panda):
    assert load_description(panda).joint_names == tuple(joint_positions(panda, panda.home))


def test_the_arm_of_the_description_is_that_of_the_panda(panda):
    robot, q = load_description(panda), panda.random(20, seed=0)
    ours = robot.forward_kinematics(np.hstack([q, np.full((20, 2), 0.02)]), link="panda_ee")
    assert np.array_equal(ours, panda.forward_kinematics(q))


def test_the_frames_of_the_fingers_are_those_of_their_visuals(panda):
    robot, urdf = load_description(panda), etree.fromstring(panda.to_urdf().encode())
    q = list(joint_positions(panda, panda.home).values())
    T_base_flange = robot.forward_kinematics(q, link="panda_link8")
    drawn = urdf.xpath("//visual[geometry/mesh[contains(@filename, 'finger')]]/origin")
    for origin, link in zip(drawn, ("panda_leftfinger", "panda_rightfinger"), strict=True):
        xyz, rpy = ([float(v) for v in origin.get(name).split()] for name in ("xyz", "rpy"))
        assert np.allclose(robot.forward_kinematics(q, link=link), T_base_flange @ pose(xyz, rpy), atol=1e-6)
