"""A robot as the text that a map carries."""

import json

import numpy as np
import pytest

import ulna
from robots import every_joint
from ulna.reachability.model import robot_from_json, robot_to_json


def again(robot, *, checked=True):
    return robot_from_json(robot_to_json(robot, checked=checked))


def changed_arms(panda):
    hull = ulna.ConvexMesh([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 1 / 3)])
    T = ulna.pose((0.1, 0.2, 1 / 3), (0.1, -0.7, 2.2))
    yield panda
    yield panda.with_tool(T)
    yield panda.with_attached("part", hull, T, touch_links=["panda_link7"])
    yield panda.with_allowed_collisions(panda.allowed_collisions.plus(("panda_link0", "panda_link7")))
    yield ulna.Robot(panda.description, home=panda.home + 0.1)


def test_it_is_the_same_robot_to_the_last_bit(panda):
    for robot in changed_arms(panda):
        copy, q = again(robot), robot.random(200, seed=3)
        T = robot.forward_kinematics(q)
        assert (copy.forward_kinematics(q) == T).all()
        assert (copy.signed_distance(q) == robot.signed_distance(q)).all()
        mine, theirs = (one.inverse_kinematics(T[:50], world=ulna.World()) for one in (robot, copy))
        assert (mine.q == theirs.q).all()
        assert (mine.info == theirs.info).all()


def test_every_type_of_joint_is_written():
    robot = ulna.Robot(every_joint())
    q = robot.random(20, seed=1)
    assert (again(robot, checked=False).link_poses(q) == robot.link_poses(q)).all()
    assert again(robot, checked=False).joint_names == robot.joint_names


def test_its_own_text_is_the_same_again(panda):
    text = robot_to_json(panda, checked=True)
    assert robot_to_json(robot_from_json(text), checked=True) == text


def test_what_something_weighs_makes_no_other_robot(panda):
    cup = ulna.Sphere(0.05), np.eye(4)
    light, heavy = panda.with_attached("cup", *cup), panda.with_attached("cup", *cup, mass=1.0)
    assert robot_to_json(light, checked=True) == robot_to_json(heavy, checked=True)
    assert "inertia" not in robot_to_json(heavy, checked=True)


def test_what_is_seen_makes_no_other_robot(panda):
    assert "visual" not in robot_to_json(panda, checked=False)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"description": {"kind": "Popen", "args": "ls"}, "home": [], "attached": [], "allowed": null}',
        '{"description": {"kind": "Description", "name": "a"}, "home": [], "attached": [], "allowed": null}',
    ],
)
def test_what_is_no_robot_is_refused(text):
    with pytest.raises(ulna.DescriptionError, match="the map's robot cannot be read"):
        robot_from_json(text)


def test_a_changed_number_is_another_robot(panda):
    data = json.loads(robot_to_json(panda, checked=False))
    data["description"]["joints"][3]["origin"][0][3] += 1e-9
    assert not np.array_equal(robot_from_json(json.dumps(data)).link_poses(panda.home), panda.link_poses(panda.home))
