"""The tab of plans in a browser: joints that are ticked as held keep their positions."""

import numpy as np
import pytest

import two_arms
import ulna
from browser import wait_to_see
from processes import wait_for

pytestmark = pytest.mark.slow


def test_a_ticked_joint_keeps_its_position_and_so_do_those_that_need_not_move(open_page):
    robot = ulna.load(two_arms.URDF, srdf=two_arms.SRDF)
    with ulna.view(robot) as view:
        assert view.plans is not None
        planning = view.plans.planning
        page = open_page(view.url)
        page.get_by_role("tab", name="Plan").click()
        page.get_by_role("button", name="Plan a motion").click()
        wait_to_see(page, lambda: "no goal yet" in page.inner_text("body"), "the request for a goal")
        page.get_by_text("Held joints").click()
        page.get_by_label("Hold left_joint3", exact=True).click()
        wait_for(lambda: planning.held == ("left_joint3",), "the held joint", looks=None)
        start = view.q.copy()
        page.get_by_role("button", name="left_arm/up").click()
        wait_to_see(page, lambda: "solved: " in page.inner_text("body"), "a plan")
        shown, names = planning.shown, np.array(robot.joint_names)
        assert shown is not None
        path = shown.plan.path
        assert np.array_equal(path[0], start)
        assert np.isclose(path[-1, names == "left_joint2"], robot.named_configurations["left_arm/up"][names == "left_joint2"])
        stays = (robot.named_configurations["left_arm/up"] == start) | (names == "left_joint3")
        assert stays.any()
        assert (path[:, stays] == start[stays]).all()
