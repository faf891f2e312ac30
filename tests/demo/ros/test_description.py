"""The description for robot_state_publisher, without ROS: it has every joint that is published, and the arm is the same."""

import numpy as np
from lxml import etree

import ulna
from ulna.demo.drawing import joint_positions
from ulna.demo.ros.description import with_fingers
from ulna.description.pose import pose


def described(panda):
    return ulna.load(with_fingers(panda.to_urdf()))


def test_it_has_the_joints_that_are_published_and_no_others(panda):
    assert described(panda).joint_names == tuple(joint_positions(panda, panda.home))


def test_the_arm_is_the_same(panda):
    robot, q = described(panda), panda.random(20, seed=0)
    ours = robot.forward_kinematics(np.hstack([q, np.full((20, 2), 0.02)]), "panda_ee")
    assert np.array_equal(ours, panda.forward_kinematics(q))


def test_the_fingers_frames_are_where_the_fingers_are_drawn(panda):
    robot, urdf = described(panda), etree.fromstring(panda.to_urdf().encode())
    q = list(joint_positions(panda, panda.home).values())
    T_base_flange = robot.forward_kinematics(q, "panda_link8")
    drawn = urdf.xpath("//visual[geometry/mesh[contains(@filename, 'finger')]]/origin")
    for origin, link in zip(drawn, ("panda_leftfinger", "panda_rightfinger"), strict=True):
        xyz, rpy = ([float(v) for v in origin.get(name).split()] for name in ("xyz", "rpy"))
        assert np.allclose(robot.forward_kinematics(q, link), T_base_flange @ pose(xyz, rpy), atol=1e-6)
