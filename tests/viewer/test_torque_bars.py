"""The bars of torque beside the sliders of joints."""

import re

import numpy as np
import pytest

import ulna
from processes import wait_for
from ulna.viewer.html import load_bar
from ulna.viewer.joint_sliders import JointSliders
from ulna.viewer.page import Page
from ulna.viewer.palette import GREEN, RED, STOPPED, UNKNOWN
from ulna.viewer.session.loads import Load, has_inertias, loads


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


def test_loads_are_those_of_what_the_robot_holds_as_it_is_mounted(panda):
    robot = panda.with_attached("part", ulna.Box((0.1, 0.1, 0.1)), np.eye(4), mass=4.0).with_gravity((9.81, 0, 0))
    found = loads(robot, robot.home)
    assert [load.torque for load in found] == robot.gravity_torque(robot.home).tolist()
    assert [load.limit for load in found] == robot.effort_limits.tolist()
    assert str(Load(-22.04, 87.0, "Nm")) == "22.0 of 87 Nm"
    assert str(Load(3.0, np.inf, "N")) == "3.0 N, no limit known"


@pytest.mark.parametrize(
    ("torque", "limit", "color", "width"),
    [
        (0.0, 10, GREEN, 0),
        (-7.9, 10, GREEN, 79),
        (8.1, 10, STOPPED, 81),
        (10, 10, STOPPED, 100),
        (10.1, 10, RED, 100),
        (3, np.inf, UNKNOWN, 0),
    ],
)
def test_a_bar_is_as_long_as_its_share_and_full_beyond_the_limit(torque, limit, color, width):
    bar = load_bar("j<1>", Load(torque, limit, "Nm"))
    assert f"--mark:rgb{color};" in bar
    assert f'aria-valuenow="{width}"' in bar
    assert float(re.search(r'<div style="width:([\d.]+)%', bar)[1]) == width
    assert "j&lt;1&gt;" in bar


def test_without_inertias_there_is_no_bar(panda, server):
    assert has_inertias(panda)
    for robot in (panda.with_inertias({"panda_link3": None}), ulna.Robot.from_dh([(0, 0, 0, 0)])):
        assert not has_inertias(robot)
        with ulna.view(robot) as view:
            assert not any(bar.visible for bar in view.joints.bars.values())
    joints = JointSliders(server.gui, panda, lambda: None)
    joints.show_loads(loads(panda, panda.home))
    assert all(bar.visible and "of 87 Nm" in bar.content for bar in list(joints.bars.values())[:4])
    joints.show_loads(())
    assert not any(bar.visible for bar in joints.bars.values())


@pytest.mark.slow
def test_the_bars_on_the_page_follow_the_arm(view, page, panda):
    bar = page.get_by_label("holding torque of panda_joint2")
    for bent in (0.0, 1.2):
        view.q = panda.home + np.array([0, bent, 0, 1.0, 0, 0, 0])
        words = f"{abs(panda.gravity_torque(view.q)[1]):.1f} of 87 Nm"
        wait_for(lambda words=words: bar.get_attribute("aria-valuetext") == words, words, looks=None)
        assert page.get_by_text(f"holding {words}").is_visible()
