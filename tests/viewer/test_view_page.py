"""The page of ``ulna view`` in headless Chromium: pixels, text and numbers."""

import json

import numpy as np
import pytest

import ulna
from browser import around, pixels, project
from colors import count
from processes import wait_for


@pytest.fixture(scope="module")
def view(panda):
    with ulna.view(panda) as view:
        yield view


@pytest.fixture(scope="module")
def page(view, open_page):
    page = open_page(view.url)
    wait_for(lambda: bool(view.page.server.get_clients()), "the page's connection")
    yield page
    page.close()


@pytest.fixture
def camera(view, page, panda):
    """The robot at home, alone; and what the one page's camera sees."""
    view.obstacles.replace(ulna.World())
    view.q = panda.home
    wait_for(lambda: np.allclose(view.hand.handles.pose, view.session.hand_pose), "the handles at the hand")
    return next(iter(view.page.server.get_clients().values())).camera


def tab(page, name):
    page.get_by_role("tab", name=name).click()


def drag(page, start, way, steps=12):
    page.mouse.move(*start)
    page.mouse.down()
    for k in range(1, steps + 1):
        page.mouse.move(start[0] + way[0] * k / steps, start[1] + way[1] * k / steps)
        page.wait_for_timeout(30)


def arrow(camera, T, axis, size):
    """Where the head of an arrow of some handles is seen."""
    return project(camera, T[:3, 3] + 0.95 * size * T[:3, axis])


def test_a_number_typed_at_a_slider_moves_that_joint_alone(view, page, camera, panda):
    tab(page, "Move")
    field = page.get_by_role("textbox", name="joint4")
    field.fill("-1.2")
    field.press("Enter")
    wait_for(lambda: view.q[3] == pytest.approx(-1.2), "joint 4 at -1.2")
    assert np.array_equal(np.delete(view.q, 3), np.delete(panda.home, 3))
    view.q = panda.home
    wait_for(lambda: field.input_value() == "-2.356", "the slider at home again")


def test_the_hand_is_dragged_and_the_arm_follows(view, page, camera):
    tab(page, "Move")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, arrow(camera, T, 2, size), (0, 60))
    page.get_by_text("the hand follows").wait_for()
    wait_for(lambda: not view.session.moving, "the hand at rest")
    reached = view.session.hand_pose
    page.mouse.up()
    assert reached[2, 3] < T[2, 3] - 0.03
    assert np.allclose(reached[:2, 3], T[:2, 3], atol=1e-3)
    assert np.allclose(reached[:3, :3], T[:3, :3], atol=1e-3)
    page.get_by_text("drag the handles to move the hand").wait_for()


def test_out_of_reach_the_mark_is_red_and_the_page_says_why(view, page, camera):
    tab(page, "Move")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, arrow(camera, T, 2, size), (0, -340))
    wait_for(lambda: view.session.trouble, "a hand that cannot follow")
    status = page.get_by_role("status").nth(1)
    wait_for(lambda: status.inner_text().strip() == view.session.trouble, "the reason on the page")
    assert view.session.trouble.partition(":")[0] in ("unreachable", "joint limits", "beyond max_step")
    place = project(camera, view.hand.handles.pose[:3, 3])
    wait_for(lambda: count(around(pixels(page), place, 14), "red") > 100, "a red mark")
    page.mouse.up()
    wait_for(lambda: np.allclose(view.hand.handles.pose, view.session.hand_pose, atol=1e-4), "the handles back at the hand")


def test_obstacles_are_added_sized_moved_named_and_deleted(view, page, camera):
    tab(page, "Obstacles")
    page.get_by_role("button", name="Cylinder").click()
    wait_for(lambda: view.world.names == ("cylinder 1",), "a cylinder")
    for label, value in (("Radius [m]", "0.05"), ("Length [m]", "0.3"), ("Position [m]", "0.7"), ("Name", "post")):
        field = page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
        page.wait_for_timeout(150)
    wait_for(lambda: view.world.names == ("post",), "its new name")
    assert view.world.shape("post") == ulna.Cylinder(0.05, 0.3)
    assert view.world.pose("post")[0, 3] == pytest.approx(0.7)
    page.get_by_role("button", name="Delete").click()
    wait_for(lambda: view.world.names == (), "nothing left")


def test_the_nearest_pair_has_a_line_with_its_distance(view, page, camera, panda):
    view.world.add("ball", ulna.Sphere(0.05), ulna.pose((0.65, 0.0, 0.5)))
    wait_for(lambda: view.session.clearance.nearest is not None, "a nearest pair")
    pair = view.session.clearance.nearest
    distance = panda.signed_distance(panda.home, view.world, self_collision=False)
    page.get_by_text(f"{1000 * distance:.1f} mm: {pair.name_a} and ball").wait_for()
    assert pair.name_b == "ball"
    middle = project(camera, (pair.witness_a + pair.witness_b) / 2)
    wait_for(lambda: np.count_nonzero(around(pixels(page), middle, 8).max(axis=-1) < 130) > 5, "a dark line")


def test_a_scene_is_saved_and_loaded_by_the_page(view, page, camera, tmp_path):
    tab(page, "Obstacles")
    view.world.add("ball", ulna.Sphere(0.05), ulna.pose((0.65, 0.1, 0.5)))
    with page.expect_download() as download:
        page.get_by_role("button", name="Save scene").click()
    path = tmp_path / "scene.json"
    download.value.save_as(path)
    assert ulna.load_world(path).names == ("ball",)
    text = json.loads(path.read_text())
    text["objects"][0]["name"] = "globe"
    path.write_text(json.dumps(text))
    page.locator("input[type=file]").set_input_files(path)
    wait_for(lambda: view.world.names == ("globe",), "the loaded scene")
    path.write_text('{"ulna_scene": 1, "objects": [{"name": "a", "shape": "bix"}]}')
    page.locator("input[type=file]").set_input_files(path.rename(tmp_path / "bad.json"))
    page.get_by_text("bad.json: object 1 'a': 'bix' is no shape; did you mean 'box'?").wait_for()
    assert view.world.names == ("globe",)


def test_every_control_has_a_name(view, page, camera):
    view.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.6, -0.3, 0.5)))
    view.obstacles.form.choose("crate")
    for name in ("Move", "Obstacles", "Look"):
        tab(page, name)
        page.wait_for_timeout(400)
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('input:not([type=hidden]), textarea, button, [role=slider], [role=tab]')]
        .filter((e) => e.getAttribute('aria-hidden') !== 'true')
        .filter((e) => !(e.ariaLabel || '').trim() && !(e.labels?.[0]?.textContent ?? '').trim() && !e.textContent.trim())
        .map((e) => e.outerHTML.slice(0, 200))"""
    )
    assert nameless == []
    for label in ("joint1", "Extents [m]", "Extents [m], z", "Name", "Hand", "Avoid collisions", "Visuals"):
        assert page.get_by_label(label, exact=True).count() > 0, label
