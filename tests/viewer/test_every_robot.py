"""Every robot of every collection on this machine has a page, and controls that take its limits. No browser."""

import numpy as np
import pytest

import ulna
from processes import wait_for
from robot_files import example_urdfs, of_kinds, rtb_package_dirs, rtb_xacros
from ulna.viewer.joint_sliders import JointSliders
from ulna.viewer.move_panel import HandPanel
from ulna.viewer.page import Page
from ulna.viewer.readings import EllipsoidPanel
from ulna.viewer.session.session import Session

NOT_LOADED = {"alex_psyonic_hands", "ur3", "kr210l150"}  # tests/crosscheck has the reasons
URDFS = [file for file in example_urdfs() if file.stem not in NOT_LOADED]


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


def check_page(robot, server):
    """Build the controls, and show them at home and at both limits."""
    session = Session(robot)
    if robot.n_dof:
        HandPanel(server, session, 1.0, lambda: None).show()
        EllipsoidPanel(server, session).show()
    joints = JointSliders(server.gui, robot, lambda: None)
    for q in (robot.home, robot.lower, robot.upper):
        joints.show(np.where(np.isfinite(q), q, 7.0))
    for slide, slider in joints.sliders.values():
        assert slide.low <= slider.value <= slide.high
    server.gui.reset()
    server.scene.reset()


def test_joints_in_degrees(panda, server):
    joints, q = JointSliders(server.gui, panda, lambda: None), panda.home + 0.1
    joints.show(q)
    joints.degrees.value = True
    highest = np.degrees(panda.upper[1])
    wait_for(lambda: np.isclose(joints.sliders[1][1].max, highest, atol=0.01), "the limits in degrees", looks=None)
    assert np.allclose([slider.value for _, slider in joints.sliders.values()], np.degrees(q), atol=0.02)
    joints.degrees.value = False
    wait_for(lambda: np.isclose(joints.sliders[1][1].max, panda.upper[1]), "the limits in radians", looks=None)
    assert np.allclose([slider.value for _, slider in joints.sliders.values()], q, atol=1e-3)


@pytest.mark.parametrize("name", ["panda", "ur10e", "gen3", "irb6640", "vx300s", "kinova", "a1", "hyq"])
def test_a_page_for_a_robot_by_name(name, server):
    check_page(ulna.load(name), server)


@pytest.mark.parametrize("file", of_kinds(URDFS), ids=lambda file: file.stem)
def test_a_page_for_every_robot_of_example_robot_data(file, server):
    check_page(ulna.load(file), server)


@pytest.mark.slow
def test_a_page_for_every_robot_of_rtb_data(server, tmp_path):
    packages = rtb_package_dirs(tmp_path)
    for file in rtb_xacros():
        if file.stem not in NOT_LOADED:
            check_page(ulna.load(file, package_dirs=packages), server)


def check_view(robot):
    """Start the whole page, at home, until its first frame is drawn."""
    with ulna.view(robot) as view:
        wait_for(lambda: "checking" not in view.clearance.state.content, "the first frame", looks=None)
        assert not view.notice.text.startswith("This picture is out of date")


@pytest.mark.slow
@pytest.mark.parametrize("file", URDFS, ids=lambda file: file.stem)
def test_ulna_view_shows_every_robot_of_example_robot_data(file):
    check_view(ulna.load(file))
