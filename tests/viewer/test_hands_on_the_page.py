"""The hands and the light of the page in a browser: what is grabbed moves, the pad steers, what touches is red."""

import numpy as np
import pytest

import ulna
from browser import around, camera_of, pixels, project, wait_to_see
from colors import count

pytestmark = pytest.mark.slow

AT = (0.55, 0.3, 0.1)


@pytest.fixture
def view(panda):
    world = ulna.World()
    world.add("crate", ulna.Box((0.2, 0.2, 0.2)), ulna.pose(AT))
    world.add("table", ulna.Box((0.3, 0.3, 0.05)), ulna.pose((-0.6, 0.0, -0.025)))
    with ulna.view(panda, world) as view:
        yield view


def settled(page, view):
    """The camera, once it rests."""
    camera, places = camera_of(page, view.page.server), [np.full(3, 3.0)]

    def rests():
        places.append(camera.position)
        page.wait_for_timeout(300)
        return np.array_equal(places[-1], places[-2]) and not np.allclose(places[-1], 3.0)

    wait_to_see(page, rests, "a camera that rests")
    return camera


@pytest.mark.parametrize("key", [None, "Shift"])
def test_an_obstacle_is_dragged_itself_and_the_view_stays(view, page, key):
    camera = settled(page, view)
    start, before = project(camera, AT), camera.position
    wait_to_see(page, lambda: np.ptp(around(pixels(page), start, 8), axis=-1).mean() > 40, "the crate in its color")
    page.mouse.move(*start)
    if key:
        page.keyboard.down(key)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(start[0] + 6 * k, start[1] - 8 * k)
        page.wait_for_timeout(60)
    wait_to_see(page, lambda: np.linalg.norm(view.world.pose("crate")[:3, 3] - AT) > 0.05, "the crate elsewhere")
    page.mouse.up()
    if key:
        page.keyboard.up(key)
    wait_to_see(page, lambda: not view.obstacles.handles.dragged, "a crate that is let go")
    now = view.world.pose("crate")[:3, 3]
    if key:
        assert now[2] > AT[2] + 0.02, "with Shift it is lifted, parallel to the screen"
    else:
        assert now[2] == pytest.approx(AT[2], abs=1e-6), "without, it stays at its height"
    np.testing.assert_allclose(camera.position, before, atol=1e-6)
    assert view.obstacles.chosen == "crate"
    wait_to_see(page, lambda: view.obstacles.history.can_undo, "a step to undo")
    page.keyboard.press("Control+z")
    wait_to_see(page, lambda: np.allclose(view.world.pose("crate")[:3, 3], AT, atol=1e-9), "the crate where it was")


def test_the_pad_has_three_buttons_in_a_row_and_moves_by_steps_and_by_joints(view, page, panda):
    page.get_by_role("tab", name="Steer").click()
    page.get_by_text("It slows down and stops before an obstacle").wait_for()
    page.get_by_role("button", name="Steer the hand").click()
    wait_to_see(page, lambda: view.steer.steering.can_move, "an arm that can be steered")
    x, y, z, below = (page.get_by_role("button", name=f"move {way}").bounding_box() for way in ("+x", "+y", "+z", "-x"))
    assert x["y"] == y["y"] == z["y"] < below["y"]
    assert x["x"] + x["width"] <= y["x"] < z["x"]
    assert below["x"] == x["x"]
    with view.session.lock:
        view.steer.step.value = "1 cm or 5°"
    before = panda.forward_kinematics(view.q)
    page.get_by_role("button", name="move -z").click()
    wait_to_see(page, lambda: view.q[3] != panda.home[3] and not view.steer.moving, "a step that has ended")
    after = panda.forward_kinematics(view.q)
    np.testing.assert_allclose((after - before)[:3, 3], (0, 0, -0.01), atol=1.5e-3)
    view.steer.axes.value = "joints"
    view.steer._choose()
    view._on_event()
    q = view.q
    page.get_by_role("button", name="+ panda_joint1").click()
    wait_to_see(page, lambda: abs(view.q[0] - q[0]) > np.radians(4) and not view.steer.moving, "a step of a joint")
    np.testing.assert_allclose(view.q - q, np.eye(7)[0] * np.radians(5), atol=3e-3)


def test_a_servo_that_may_not_start_says_so_in_words_and_leads_out(view, page, panda):
    page.get_by_role("tab", name="Steer").click()
    page.get_by_role("button", name="Steer the hand").click()
    wait_to_see(page, lambda: view.steer.steering.can_move, "an arm that can be steered")
    view.world.move("crate", panda.forward_kinematics(panda.home))
    wait_to_see(page, lambda: "and crate touch: move the obstacle" in page.inner_text("body"), "why, in words")
    assert page.get_by_role("button", name="move +x").is_disabled()
    page.get_by_role("button", name="Go to a free pose").click()
    wait_to_see(page, lambda: view.steer.steering.can_move, "an arm that can be steered again")
    assert not panda.in_collision(view.q, view.world)
    wait_to_see(page, lambda: page.get_by_role("button", name="move +x").is_enabled(), "live buttons")


def test_a_link_that_touches_is_red_without_its_shapes(view, page, panda):
    camera = settled(page, view)
    hand = panda.forward_kinematics(panda.home, link="panda_link8")[:3, 3]
    place = project(camera, hand)
    assert count(around(pixels(page), place, 25), "red") < 100
    view.world.move("crate", ulna.pose(hand) @ ulna.pose((-0.12, 0.05, 0.0)))
    wait_to_see(page, lambda: view.session.clearance.state == "collision", "a collision")
    wait_to_see(page, lambda: count(around(pixels(page), place, 25), "red") > 300, "a red hand")
    assert not view.arm.solids["box 1"].visible
    view.world.move("crate", ulna.pose(AT))
    wait_to_see(page, lambda: count(around(pixels(page), place, 25), "red") < 100, "a hand that is not red")


def test_the_shape_from_which_the_distance_is_measured_is_shown_faintly(view, page):
    wait_to_see(page, lambda: view.session.clearance.nearest is not None, "the nearest pair")
    near = view.session.clearance.nearest.name_a
    wait_to_see(page, lambda: view.arm.solids[near].visible, "its shape")
    assert [name for name, node in view.arm.solids.items() if node.visible] == [near]


def test_the_sky_is_a_gradient_and_the_floor_lies_under_what_stands_there(view, page):
    settled(page, view)
    image = pixels(page)
    assert image[5, 5].min() > image[-5, 5].min() + 8
    assert view.page.floor.position[2] < -0.05


def test_labels_are_above_their_fields_large_and_dark_enough(page):
    label = page.get_by_text("Hand xyz [m]", exact=True)
    field = page.get_by_role("textbox", name="Hand xyz [m]", exact=True)
    above, below = label.bounding_box(), field.bounding_box()
    assert above["y"] + above["height"] <= below["y"] + 1
    assert below["width"] > 60
    size, color = label.evaluate("(e) => [getComputedStyle(e).fontSize, getComputedStyle(e).color]")
    assert 12 <= float(size.removesuffix("px")) <= 13
    share = np.array([int(part) for part in color.removeprefix("rgb(").removesuffix(")").split(",")]) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)
    assert 1.05 / (light + 0.05) > 4.5  # WCAG 2.2, criterion 1.4.3
