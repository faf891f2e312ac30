"""The sliders of the joints, in groups, and the text of the kinematic tree."""

import numpy as np
import pytest

import robots
import ulna
from ulna.viewer.html import outline
from ulna.viewer.session.slides import limbs, slide_groups


@pytest.fixture(scope="module")
def talos():
    return ulna.load("talos")


def test_a_serial_arm_has_one_group_with_its_limits(panda):
    (group,) = slide_groups(panda)
    assert [slide.name for slide in group.slides] == list(panda.joint_names)
    assert np.array_equal([(slide.low, slide.high) for slide in group.slides], np.transpose([panda.lower, panda.upper]))


def test_a_humanoid_has_a_group_for_each_limb(talos):
    names = [group.name for group in slide_groups(talos)]
    assert names == ["torso", "head", "arm_left", "arm_right", "leg_left", "leg_right"]


@pytest.mark.parametrize("name", ["panda", "talos", "pr2", "tiago_dual", "hyq"])
def test_every_entry_of_q_has_one_slider(name):
    robot = ulna.load(name)
    columns = [slide.column for group in slide_groups(robot) for slide in group.slides]
    assert sorted(columns) == list(range(robot.n_dof))
    assert sorted(joint for limb in limbs(robot) for joint in limb) == sorted(robot.joint_names)


def test_planar_and_floating_joints_have_one_slider_per_component():
    robot = ulna.Robot(robots.of_chain("planar", "floating", "continuous"))
    slides = [slide for group in slide_groups(robot) for slide in group.slides]
    assert [(slide.name, slide.unit) for slide in slides[:3]] == [("j1.x", "m"), ("j1.y", "m"), ("j1.theta", "rad")]
    assert [slide.name for slide in slides[3:9]] == [f"j2.{part}" for part in ("x", "y", "z", "roll", "pitch", "yaw")]
    assert (slides[9].low, slides[9].high) == (-np.pi, np.pi)
    assert all(np.isfinite([slide.low, slide.high]).all() for slide in slides)


def test_a_slider_subtracts_whole_turns_and_stays_in_its_range():
    robot = ulna.Robot(robots.of_chain("continuous"))
    slide = slide_groups(robot)[0].slides[0]
    assert slide.shown(np.array([2 * np.pi + 0.5])) == pytest.approx(0.5)
    assert slide.shown(np.array([-3.5])) == pytest.approx(2 * np.pi - 3.5)
    limited = slide_groups(ulna.load("panda"))[0].slides[0]
    assert limited.shown(np.full(7, 5.0)) == limited.high


def test_a_mimic_joint_is_shown_at_its_multiplier_times_the_leader_plus_offset():
    robot = ulna.load("pr2")
    followers = [follower for group in slide_groups(robot) for follower in group.followers]
    assert len(followers) == sum(joint.mimic is not None for joint in robot.description.joints)
    q = robot.home + 0.1
    for follower in followers:
        leader = robot.joint_slices[robot.joint_names.index(follower.leader)].start
        mimic = next(joint.mimic for joint in robot.description.joints if joint.name == follower.name)
        assert follower.position(q) == pytest.approx(mimic.multiplier * q[leader] + mimic.offset)
        assert follower.hint.startswith(f"Mimic joint: {follower.name} = ")


def test_the_outline_lists_every_link_below_its_parent(talos):
    lines = outline(talos)
    assert sorted(line.link for line in lines) == sorted(talos.link_names)
    place = {line.link: k for k, line in enumerate(lines)}
    for line in lines[1:]:
        parent = lines[place[line.joint.parent]]
        assert place[parent.link] < place[line.link]
        assert line.depth == parent.depth + 1


def test_the_groups_of_a_robot_have_different_names():
    folders = {name: [group.name for group in slide_groups(ulna.load(name))] for name in ("tiago", "pr2")}
    assert all(len(set(names)) == len(names) for names in folders.values())
    assert "r: shoulder_pan to gripper_l_finger" in folders["pr2"]
    assert "hand_thumb: abd to flex" in folders["tiago"]
