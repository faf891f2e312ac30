"""Pairs of the robot's own links that touch are allowed on the page by one click, and checked again by undo."""

import numpy as np
import pytest

import ulna
from browser import wait_to_see
from processes import wait_for

FOLDED = np.array([0.79, -0.81, -2.66, -3.02, 1.82, 3.42, 0.62])  # links 5 and 7 of the Panda in link 1
PAIRS = [("panda_link1", "panda_link5"), ("panda_link1", "panda_link7")]


@pytest.fixture
def view(panda):
    with ulna.view(panda, q=FOLDED) as view:
        yield view


def test_a_click_allows_what_touches_undo_checks_it_again(view, open_page, panda):
    page = open_page(view.url)
    allow = page.get_by_role("button", name="Allow these contacts")
    wait_for(lambda: view.session.clearance.state == "collision", "a collision", looks=None)
    wait_to_see(page, allow.count, "the button")
    allow.click()
    wait_to_see(page, lambda: view.session.clearance.state == "free", "no collision")
    wait_to_see(page, lambda: not allow.count(), "no button")
    added = [pair for pair in view.session.robot.allowed_collisions if pair not in panda.allowed_collisions]
    assert sorted((pair.link_a, pair.link_b) for pair in added) == PAIRS
    shown = page.get_by_text("These links may touch: ")
    wait_to_see(page, shown.count, "the pairs")
    copied = page.get_by_role("button", name="Copy for a program").get_attribute("data-copy")
    assert not eval(copied, {"robot": panda}).in_collision(FOLDED)  # noqa: S307 - what a person would paste
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Control+z")
    wait_to_see(page, lambda: view.session.clearance.state == "collision" and allow.count(), "the collision")
    assert view.session.robot is panda
    wait_to_see(page, lambda: not shown.count(), "no pairs")
    page.keyboard.press("Control+Shift+z")
    wait_to_see(page, lambda: view.session.clearance.state == "free", "no collision")


def test_an_obstacle_that_touches_is_not_to_be_allowed(view, panda):
    view.world.add("ball", ulna.Sphere(0.1), panda.forward_kinematics(panda.home))
    view.q = panda.home
    wait_for(lambda: view.session.clearance.touching.endswith("ball"), "a collision of the ball alone", looks=None)
    wait_for(lambda: not view.allow.visible, "no button", looks=None)
    assert view.session.own_contacts == ()
