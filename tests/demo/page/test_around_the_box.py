"""The checkbox "Plan around the box" in a browser: off at first; the page says that there is a way, and that there is none."""

import pytest

from browser import wait_to_see
from ulna.demo.page import DemoApp
from ulna.demo.scenario import BOX_START, Demo
from ulna.description.pose import pose


@pytest.fixture
def app():
    app = DemoApp(Demo(), port=0)
    yield app
    app.stop()


def test_the_arm_goes_round_the_box_or_the_page_says_that_there_is_no_way(app, open_page):
    page = open_page(app.url)
    page.get_by_text("free", exact=True).first.wait_for()
    box = page.get_by_role("checkbox", name="Plan around the box")
    assert not box.is_checked()
    assert page.get_by_role("status").count() == 1
    box.check()
    page.get_by_text("certified free").wait_for()
    q = app.player.q
    wait_to_see(page, lambda: abs(app.player.q - q).max() > 0.05, "an arm that moves")
    app.put_box(pose(app.demo.robot.forward_kinematics(app.player.q, link="panda_link4")[:3, 3]))
    page.get_by_text("the arm is in the box: move the box away").wait_for()
    assert app.player.report.in_collision
    app.put_box(pose(BOX_START))
    page.get_by_text("certified free").wait_for()
    box.uncheck()
    wait_to_see(page, lambda: page.get_by_role("status").count() == 1, "the word of the light alone")
    assert not app.player.avoiding
