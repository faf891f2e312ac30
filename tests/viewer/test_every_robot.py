"""Every robot of every collection on this machine has a page: all its controls, at home and at its limits. No browser."""

import numpy as np
import pytest

import ulna
from robot_files import example_urdfs, rtb_package_dirs, rtb_xacros
from ulna.viewer.ellipsoid import EllipsoidPanel
from ulna.viewer.hand import HandPanel
from ulna.viewer.joints import JointSliders
from ulna.viewer.page import Page
from ulna.viewer.session.session import Session

NOT_LOADED = {"alex_psyonic_hands", "ur3", "kr210l150"}  # tests/crosscheck has the reasons


@pytest.fixture(scope="module")
def server():
    page = Page(port=0)
    yield page.server
    page.stop()


def has_a_page(robot, server):
    """Make the controls, and let them show where the robot may stand."""
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


@pytest.mark.parametrize("name", ["panda", "kinova", "a1", "hyq"])
def test_a_robot_by_name_has_a_page(name, server):
    has_a_page(ulna.load(name), server)


@pytest.mark.parametrize("file", [file for file in example_urdfs() if file.stem not in NOT_LOADED], ids=lambda file: file.stem)
def test_every_robot_of_example_robot_data_has_a_page(file, server):
    has_a_page(ulna.load(file), server)


def test_every_robot_of_rtb_data_has_a_page(server, tmp_path):
    packages = rtb_package_dirs(tmp_path)
    for file in rtb_xacros():
        if file.stem not in NOT_LOADED:
            has_a_page(ulna.load(file, package_dirs=packages), server)
