"""The page of ``ulna view`` in headless Chromium: pixels, text and numbers."""

import json

import numpy as np
import pytest

import ulna
from browser import around, arrow, camera_of, drag, pixels, project, wait_to_see
from colors import count
from ulna.viewer.move_panel import as_text
from ulna.viewer.readings import COLOR

NAMELESS = """() => [...document.querySelectorAll('input:not([type=hidden]), textarea, button, [role=slider], [role=tab]')]
    .filter((e) => e.getAttribute('aria-hidden') !== 'true')
    .filter((e) => !(e.ariaLabel || '').trim() && !(e.labels?.[0]?.textContent ?? '').trim() && !e.textContent.trim())
    .map((e) => e.outerHTML.slice(0, 200))"""


@pytest.fixture
def camera(view, page):
    """The camera of the only tab."""
    return camera_of(page, view.page.server)


def tab(page, name):
    page.get_by_role("tab", name=name).click()


@pytest.mark.slow
def test_visuals_shapes_frames_and_names_are_shown_and_hidden(view, page, camera, panda):
    tab(page, "Look")
    elbow = project(camera, panda.forward_kinematics(panda.home, link="panda_link4")[:3, 3])

    def drawn():
        return np.count_nonzero(around(pixels(page), elbow, 12).max(axis=-1) < 215) > 200

    wait_to_see(page, drawn, "the elbow")
    page.get_by_role("checkbox", name="Visuals").uncheck()
    wait_to_see(page, lambda: not drawn(), "nothing at the elbow")
    page.get_by_role("checkbox", name="Link names").check()
    wait_to_see(page, lambda: np.count_nonzero(around(pixels(page), elbow, 12).max(axis=-1) < 215) > 50, "its name")
    page.get_by_role("checkbox", name="Link frames").check()
    wait_to_see(page, lambda: count(around(pixels(page), elbow, 40), "blue") > 20, "the blue axis of link 4")
    page.get_by_role("checkbox", name="Link frames").uncheck()
    page.get_by_role("checkbox", name="Link names").uncheck()
    page.get_by_role("checkbox", name="Collision shapes").check()
    wait_to_see(
        page, lambda: np.count_nonzero(np.ptp(around(pixels(page), elbow, 12), axis=-1) > 8) > 200, "a pale blue box at the elbow"
    )
    page.get_by_role("checkbox", name="Collision shapes").uncheck()
    page.get_by_role("checkbox", name="Visuals").check()
    page.get_by_text("Tree (10 links)").click()
    page.get_by_text("revolute panda_joint3").wait_for()


@pytest.mark.slow
def test_a_number_typed_at_a_slider_moves_only_that_joint(view, page, camera, panda):
    tab(page, "Move")
    field = page.get_by_role("textbox", name="joint4")
    field.fill("-1.2")
    field.press("Enter")
    wait_to_see(page, lambda: view.q[3] == pytest.approx(-1.2), "joint 4 at -1.2")
    assert np.array_equal(np.delete(view.q, 3), np.delete(panda.home, 3))
    view.q = panda.home
    wait_to_see(page, lambda: field.input_value() == "-2.356", "the slider at home again")


def test_the_hand_is_dragged_and_the_arm_follows(view, page, camera):
    tab(page, "Move")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, view.hand.handles, arrow(camera, T, 2, size), (0, 60), "blue")
    page.get_by_text("the hand follows").wait_for()
    wait_to_see(page, lambda: not view.session.moving, "the hand at rest")
    reached = view.session.hand_pose
    page.mouse.up()
    assert reached[2, 3] < T[2, 3] - 0.03
    assert np.allclose(reached[:2, 3], T[:2, 3], atol=1e-3)
    assert np.allclose(reached[:3, :3], T[:3, :3], atol=1e-3)
    page.get_by_text("drag the handles to move the hand").wait_for()


def outside(page):
    page.mouse.move(-40, 300)
    page.mouse.up()


def canceled(page):
    page.evaluate(
        "document.querySelector('canvas').dispatchEvent(new PointerEvent('pointercancel', {pointerId: 1, bubbles: true}))"
    )


def behind_another_window(page):
    page.evaluate("dispatchEvent(new Event('blur'))")


@pytest.mark.slow
@pytest.mark.parametrize("end", [outside, canceled, behind_another_window])
def test_a_drag_ends_even_if_the_page_receives_no_button_release(view, page, camera, end):
    tab(page, "Move")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, view.hand.handles, arrow(camera, T, 2, size), (0, 60), "blue")
    end(page)
    wait_to_see(page, lambda: not view.hand.handles.dragged and view.session.target is None, "a released hand")
    rested = view.session.hand_pose
    page.mouse.move(700, 500)  # with the button up, or not seen
    page.wait_for_timeout(500)
    assert np.array_equal(view.session.hand_pose, rested)
    wait_to_see(page, lambda: np.allclose(view.hand.handles.pose, rested, atol=1e-4), "the handles at the hand")


def test_an_unreachable_drag_has_a_red_mark_and_a_reason_on_the_page(view, page, camera):
    tab(page, "Move")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, view.hand.handles, arrow(camera, T, 2, size), (0, -340), "blue")
    wait_to_see(page, lambda: view.session.trouble, "a hand that cannot follow")
    status = page.get_by_role("status").nth(1)
    wait_to_see(page, lambda: status.inner_text().strip() == view.session.trouble, "the reason on the page")
    assert view.session.trouble.partition(":")[0] in ("unreachable", "joint limits", "beyond max_step")

    def mark():
        return around(pixels(page), project(camera, view.hand.handles.pose[:3, 3]), 14)

    wait_to_see(page, lambda: count(mark(), "red") > 100, "a red mark")
    page.mouse.up()
    wait_to_see(
        page, lambda: np.allclose(view.hand.handles.pose, view.session.hand_pose, atol=1e-4), "the handles back at the hand"
    )
    wait_to_see(page, lambda: not view.hand.reason.visible and not view.session.trouble, "no reason any more")
    page.get_by_text("drag the handles to move the hand").wait_for()


@pytest.mark.slow
def test_a_drag_that_avoids_collisions_names_the_obstacle_at_which_it_stops(view, page, camera):
    tab(page, "Move")
    view.world.add("table", ulna.Box((1.0, 1.0, 0.1)), ulna.pose((0.6, 0.0, 0.2)))
    page.get_by_role("checkbox", name="Avoid collisions").check()
    wait_to_see(page, lambda: view.session.avoiding, "a hand that avoids")
    T, size = view.session.hand_pose, view.hand.handles.control.scale
    drag(page, view.hand.handles, arrow(camera, T, 2, size), (0, 150), "blue")
    wait_to_see(page, lambda: view.session.stopped, "a hand that stops")
    status = page.get_by_role("status").nth(1)
    wait_to_see(
        page, lambda: status.inner_text().strip().startswith("stopped before panda_link7 (box 12) and table"), "what stops it"
    )
    page.get_by_text("free", exact=True).first.wait_for()
    assert count(around(pixels(page), project(camera, view.hand.handles.pose[:3, 3]), 14), "red") < 100
    page.mouse.up()
    page.get_by_text("drag the handles to move the hand").wait_for()


@pytest.mark.slow
def test_a_typed_pose_moves_the_hand_or_gives_a_reason(view, page, camera):
    tab(page, "Move")
    field, T = page.get_by_label("Hand xyz [m], z"), view.session.hand_pose
    wait_to_see(page, lambda: float(field.input_value()) == pytest.approx(T[2, 3], abs=6e-4), "the hand's height")
    field.fill("0.35")
    field.press("Enter")
    wait_to_see(page, lambda: view.session.hand_pose[2, 3] == pytest.approx(0.35, abs=1e-4), "the hand there")
    T[2, 3] = 0.35
    assert np.allclose(view.session.hand_pose, T, atol=1e-4)
    field.fill("9")
    field.press("Enter")
    status = page.get_by_role("status").nth(1)
    wait_to_see(page, lambda: status.inner_text().strip().startswith("unreachable: "), "why not")
    wait_to_see(page, lambda: float(field.input_value()) < 2, "the height that it has")
    page.get_by_role("button", name="home").click()
    wait_to_see(page, lambda: np.array_equal(view.q, view.session.robot.home), "the arm at home")
    page.get_by_text("drag the handles to move the hand").wait_for()


@pytest.mark.slow
def test_a_pose_is_typed_in_the_frame_of_an_obstacle(view, page, camera):
    tab(page, "Move")
    T_base_obstacle = ulna.pose((0.2, 0.6, 0.1), (0, 0, 1.0))
    view.world.add("table", ulna.Box((0.2, 0.2, 0.2)), T_base_obstacle)
    field, before = page.get_by_label("Hand xyz [m], z"), view.session.hand_pose
    page.get_by_label("In the frame of", exact=True).click()
    page.get_by_role("option", name="table", exact=True).click()
    seen = np.linalg.solve(T_base_obstacle, before)
    wait_to_see(page, lambda: float(field.input_value()) == pytest.approx(seen[2, 3], abs=6e-4), "its height in the frame")
    field.fill(f"{seen[2, 3] - 0.05:.3f}")
    field.press("Enter")
    goal = seen.copy()
    goal[2, 3] = round(seen[2, 3] - 0.05, 3)
    wait_to_see(page, lambda: np.allclose(view.session.hand_pose, T_base_obstacle @ goal, atol=1e-4), "the hand there")
    page.get_by_role("button", name="home").click()
    wait_to_see(page, lambda: np.array_equal(view.q, view.session.robot.home), "the arm at home")
    view.world.remove("table")
    page.get_by_label("In the frame of", exact=True).wait_for(state="hidden")


@pytest.mark.slow
def test_q_is_copied_saved_and_loaded(view, page, camera, tmp_path):
    tab(page, "Move")
    view.q = q = view.session.robot.home + 0.1
    page.get_by_text("Copy, save, load q").click()
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    wait_to_see(page, lambda: page.locator("[data-copy]").get_attribute("data-copy") == as_text(q), "q as text")
    page.get_by_role("button", name="Copy q").click()
    page.get_by_text("Copied").wait_for()
    assert page.evaluate("navigator.clipboard.readText()") == as_text(q)
    with page.expect_download() as download:
        page.get_by_role("button", name="Save q").click()
    path = tmp_path / "q.csv"
    download.value.save_as(path)
    view.q = view.session.robot.home
    page.locator("input[type=file]").first.set_input_files(path)
    wait_to_see(page, lambda: np.array_equal(view.q, q), "the saved q")


@pytest.mark.slow
def test_a_floor_is_an_obstacle_that_the_base_does_not_touch(view, page, camera):
    tab(page, "Obstacles")
    page.get_by_role("checkbox", name="Floor").check()
    wait_to_see(page, lambda: view.world.names == ("floor",), "a floor")
    wait_to_see(page, lambda: view.session.clearance.nearest is not None, "its distance")
    assert view.session.clearance.state == "free"
    page.get_by_role("checkbox", name="Floor").uncheck()
    wait_to_see(page, lambda: view.world.names == (), "none")


@pytest.mark.slow
def test_the_scene_is_seen_from_the_top_and_in_dark_colors(view, page, camera):
    tab(page, "Look")
    bright = pixels(page).mean()
    page.get_by_role("button", name="Light or dark theme").click()
    wait_to_see(page, lambda: page.locator("canvas").count() and pixels(page).mean() < 0.5 * bright, "a dark page")
    tab(page, "Look")
    page.get_by_text("top", exact=True).click()
    client = next(iter(view.page.server.get_clients().values()))
    wait_to_see(
        page,
        lambda: client.camera.position[2] > 5 * np.linalg.norm(client.camera.position[:2] - client.camera.look_at[:2]),
        "the top",
    )


def test_light_or_dark_is_of_the_browser_and_not_of_the_server(view, open_page):
    page = open_page(view.url, scheme="dark")
    wait_to_see(page, lambda: page.locator("canvas").count() and pixels(page).mean() < 100, "a dark page")
    other = open_page(view.url, browser=1, scheme="light")
    wait_to_see(other, lambda: other.locator("canvas").count() and pixels(other).mean() > 180, "a light page beside it")
    tab(page, "Look")
    page.get_by_role("button", name="Light or dark theme").click()
    wait_to_see(page, lambda: page.locator("canvas").count() and pixels(page).mean() > 180, "a light page")
    page.reload()
    wait_to_see(page, lambda: page.locator("canvas").count() and pixels(page).mean() > 180, "a page that stays light")


@pytest.mark.slow
def test_a_negative_extent_is_refused_and_the_field_is_reset(view, page, camera):
    tab(page, "Obstacles")
    page.get_by_role("button", name="Box").click()
    wait_to_see(page, lambda: view.world.names, "a box")
    (name,), field = view.world.names, page.get_by_label("Extents [m]", exact=True)
    shape, shown = view.world.shape(name), field.input_value()
    field.click()
    field.press("Control+a")
    field.press_sequentially("-0.2", delay=60)
    assert view.world.shape(name) == shape
    field.press("Tab")
    page.get_by_text("Not changed").wait_for()
    wait_to_see(page, lambda: field.input_value() == shown, "the extent that it has")
    assert view.world.shape(name) == shape
    field.click()
    field.press("Control+a")
    field.press_sequentially("0.3", delay=60)
    field.press("Enter")
    wait_to_see(page, lambda: view.world.shape(name).extents[0] == 0.3, "a wider box")


def test_obstacles_are_added_sized_moved_named_and_deleted(view, page, camera):
    tab(page, "Obstacles")
    page.get_by_role("button", name="Cylinder").click()
    wait_to_see(page, lambda: view.world.names == ("cylinder 1",), "a cylinder")
    for label, value, holds in (
        ("Radius [m]", "0.05", lambda: view.world.shape("cylinder 1").radius == 0.05),
        ("Length [m]", "0.3", lambda: view.world.shape("cylinder 1") == ulna.Cylinder(0.05, 0.3)),
        ("Position [m]", "0.7", lambda: view.world.pose("cylinder 1")[0, 3] == pytest.approx(0.7)),
        ("Name", "post", lambda: view.world.names == ("post",)),
    ):
        field = page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
        wait_to_see(page, holds, f"{label} {value}")
    assert view.world.shape("post") == ulna.Cylinder(0.05, 0.3)
    assert view.world.pose("post")[0, 3] == pytest.approx(0.7)
    page.get_by_role("button", name="Delete").click()
    wait_to_see(page, lambda: view.world.names == (), "nothing left")


def test_a_line_joins_the_nearest_pair_and_shows_its_distance(view, page, camera, panda):
    view.world.add("ball", ulna.Sphere(0.05), ulna.pose((0.65, 0.0, 0.5)))
    wait_to_see(page, lambda: view.session.clearance.nearest is not None, "a nearest pair")
    pair = view.session.clearance.nearest
    distance = panda.signed_distance(panda.home, view.world, self_collision=False)
    page.get_by_text(f"{1000 * distance:.1f} mm between panda_link7 ({pair.name_a}) and ball").wait_for()
    assert pair.name_b == "ball"
    middle = project(camera, (pair.witness_a + pair.witness_b) / 2)
    wait_to_see(page, lambda: np.count_nonzero(around(pixels(page), middle, 8).max(axis=-1) < 130) > 5, "a dark line")


def test_an_obstacle_dragged_into_the_robot_turns_red_and_is_reported(view, page, camera, panda):
    tab(page, "Obstacles")
    view.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.31, -0.33, 0.47)))  # no label over its arrow
    page.get_by_label("Obstacle", exact=True).click()
    page.get_by_role("option", name="crate").click()
    wait_to_see(page, lambda: view.obstacles.chosen == "crate" and view.obstacles.handles.control.visible, "its handles")
    T, size = view.world.pose("crate"), view.obstacles.handles.control.scale
    start, end = arrow(camera, T, 1, size), arrow(camera, T, 1, size + 0.30)
    drag(page, view.obstacles.handles, start, end - start, "green")
    page.get_by_text("collision: ").first.wait_for()
    page.mouse.up()
    assert view.world.pose("crate")[1, 3] > -0.2
    assert view.session.clearance.report.in_collision
    assert view.obstacles.nodes["crate"].opacity is None

    def crate():
        return around(pixels(page), project(camera, view.world.pose("crate")[:3, 3]), 25)

    wait_to_see(page, lambda: count(crate(), "red") > 300, "a red crate")
    assert view.response_time > 0.0


@pytest.mark.slow
def test_the_page_saves_and_loads_a_scene(view, page, camera, tmp_path):
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
    page.locator("input[type=file]").last.set_input_files(path)
    wait_to_see(page, lambda: view.world.names == ("globe",), "the loaded scene")
    path.write_text('{"ulna_scene": 1, "objects": [{"name": "a", "shape": "bix"}]}')
    page.locator("input[type=file]").last.set_input_files(path.rename(tmp_path / "bad.json"))
    page.get_by_text("bad.json: object 1 'a': 'bix' is not a known shape; did you mean 'box'?").wait_for()
    assert view.world.names == ("globe",)


@pytest.mark.slow
def test_the_manipulability_checkbox_shows_the_ellipsoid_and_singular_values(view, page, camera, panda):
    tab(page, "Move")
    page.get_by_role("checkbox", name="Manipulability").check()
    values = np.linalg.svd(panda.jacobian(panda.home), compute_uv=False)
    page.get_by_text(" ".join(f"{value:.3f}" for value in values)).wait_for()
    page.get_by_text(f"{panda.manipulability(panda.home):.4g}", exact=True).wait_for()
    place = project(camera, view.session.hand_pose[:3, 3] + (0, 0, 0.09))

    def violet():
        near = around(pixels(page), place, 40)
        return np.count_nonzero((near[..., 2] - near[..., 1] > 25) & (near[..., 0] - near[..., 1] > 0))

    wait_to_see(page, lambda: violet() > 300, "a violet ellipsoid")
    seen = violet()
    assert COLOR[2] > COLOR[0] > COLOR[1]
    page.get_by_role("checkbox", name="Manipulability").uncheck()
    wait_to_see(page, lambda: violet() < seen - 200, "no ellipsoid")


def test_every_control_has_an_accessible_name(view, page, camera):
    view.world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.6, -0.3, 0.5)))
    view.obstacles.form.choose("crate")
    labels = {"Move": ("joint1", "Hand", "Avoid collisions"), "Look": ("Visuals",)}
    labels["Obstacles"] = ("Extents [m]", "Extents [m], z", "Name")
    for name, expected in labels.items():
        tab(page, name)
        for label in expected:
            wait_to_see(page, lambda label=label: page.get_by_label(label, exact=True).count(), label)
        wait_to_see(page, lambda: page.evaluate(NAMELESS) == [], f"a name for every control of {name}")
