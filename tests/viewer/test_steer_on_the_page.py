"""The tab of steering in a browser: the hand moves while a button or its key is held, and the page says what limits it."""

import re

import numpy as np
import pytest

import ulna
from browser import camera_of, wait_to_see
from processes import wait_for
from ulna.viewer.session import steering

pytestmark = pytest.mark.slow


@pytest.fixture
def view(panda, monkeypatch):
    monkeypatch.setattr(steering, "_HELD_FOR", 5.0)  # drawn by a CPU, a page says only every second or so that a key is held
    world = ulna.World()
    world.add("wall", ulna.Box((0.1, 2.0, 2.0)), ulna.pose((0.6, 0, 0.5)))
    with ulna.view(panda, world, steer=True) as view:
        yield view


@pytest.fixture
def page(view, open_page):
    page = open_page(view.url)
    wait_to_see(page, lambda: "hold a button or its key" in page.inner_text("body"), "the request for a button")
    return page


def moved(view, panda, axis):
    return (panda.forward_kinematics(view.q) - panda.forward_kinematics(panda.home))[axis, 3]


def rests(view, page):
    wait_to_see(page, lambda: not view.steer.moving, "the arm at rest")
    return view.q


def test_it_moves_while_a_button_is_held(view, page, panda):
    button = page.get_by_role("button", name="move -z")
    button.hover()
    page.mouse.down()
    wait_to_see(page, lambda: moved(view, panda, 2) < -0.02, "the hand lower")
    page.mouse.up()
    q = rests(view, page)
    page.wait_for_timeout(500)
    np.testing.assert_array_equal(view.q, q)


def test_it_moves_while_a_key_is_held_and_stops_at_a_wall(view, page, panda):
    camera = camera_of(page, view.page.server)
    first = view.page.server.initial_camera.position
    wait_to_see(page, lambda: np.allclose(camera.position, first, atol=1e-3), "the camera in its place: it is elsewhere before")
    page.keyboard.down("ArrowUp")
    wait_for(
        lambda: re.search("limited by clearance: .* mm from wall", page.inner_text("body")), "what limits the hand", looks=None
    )
    page.keyboard.up("ArrowUp")
    q = rests(view, page)
    assert moved(view, panda, 0) > 0.02
    assert panda.signed_distance(q, view.world, self_collision=False) > 0.009
    np.testing.assert_allclose(camera.position, first, atol=1e-3)


def test_shift_turns_the_hand_and_a_window_that_loses_the_focus_stops_it(view, page, panda):
    page.keyboard.down("Shift")
    page.keyboard.down("PageDown")

    def angle():
        turn = panda.forward_kinematics(view.q)[:3, :3] @ panda.forward_kinematics(panda.home)[:3, :3].T
        return np.arctan2(turn[1, 0], turn[0, 0])

    wait_to_see(page, lambda: angle() < -0.05, "a turn about z")
    page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    rests(view, page)


def test_arrow_keys_in_a_field_and_on_another_tab_move_nothing(view, page, panda):
    page.get_by_role("textbox", name="Speed [m/s]").press("ArrowUp")
    page.get_by_role("tab", name="Look").click()
    page.keyboard.press("ArrowUp", delay=300)
    page.wait_for_timeout(300)
    np.testing.assert_array_equal(view.q, panda.home)
