"""What is made on the page is kept, and undone, in a browser: motions, way points, pictures, and what is done with a link."""

import io

import numpy as np
import pytest
from PIL import Image

import ulna
from browser import camera_of, project, wait_to_see
from processes import wait_for

pytestmark = pytest.mark.slow


@pytest.fixture
def world(crate):
    return crate


def press(page, keys):
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(keys)


def type_in(page, label, text):
    field = page.get_by_role("textbox", name=label, exact=True)
    field.fill(text)
    field.press("Enter")


def test_a_motion_with_way_points_is_saved_copied_and_undone(view, page, panda, tmp_path, monkeypatch):
    planning = view.plans.planning
    page.get_by_role("tab", name="Plan").click()
    page.get_by_role("button", name="Plan a motion").click()
    wait_to_see(page, lambda: planning.on, "planning")
    type_in(page, "Goal xyz [m], y", "0.3")
    wait_for(lambda: planning.shown is not None and planning.shown.motion is not None, "a plan", looks=None)
    page.get_by_role("button", name="Waypoints (0)").click()
    type_in(page, "Approach [mm]", "60")
    wait_to_see(page, lambda: view.plans.ways.approach.value == 60.0, "the approach")
    page.get_by_role("button", name="Add as a waypoint").click()
    wait_for(lambda: planning.waypoints and planning.shown and len(planning.shown.legs) == 2, "two motions", looks=None)
    page.get_by_text("approach 60 mm").wait_for()
    for ending in ("CSV", "JSON"):
        with page.expect_download() as download:
            page.get_by_role("button", name=ending, exact=True).click()
        assert download.value.suggested_filename == f"panda_motion.{ending.lower()}"
        download.value.save_as(tmp_path / f"motion.{ending.lower()}")
        again = panda.motion_from_file(tmp_path / f"motion.{ending.lower()}")
        assert again.duration == pytest.approx(planning.shown.motion.duration, abs=1e-9)
        np.testing.assert_allclose(again.q[-1], planning.shown.motion.q[-1], atol=1e-9)
    monkeypatch.chdir(tmp_path)
    made = {}
    exec(page.get_by_role("button", name="Copy as Python").get_attribute("data-copy"), made)  # noqa: S102 - as a person would
    np.testing.assert_allclose(made["motion"].q[-1], planning.shown.motion.q[-1], atol=1e-6)
    assert "ulna plan panda --from" in page.get_by_role("button", name="Copy as a command").get_attribute("data-copy")
    press(page, "Control+z")
    wait_to_see(page, lambda: not planning.waypoints and planning.hand_pose[1, 3] == 0.3, "the goal without a way point")
    press(page, "Control+z")
    wait_to_see(page, lambda: planning._goal is None, "no goal")
    press(page, "Control+Shift+z")
    wait_to_see(page, lambda: planning.hand_pose[1, 3] == 0.3, "the goal")


def test_a_move_of_the_arm_is_one_step_to_undo_and_what_the_program_does_is_none(view, page, panda):
    type_in(page, "joint1", "0.5")
    wait_to_see(page, lambda: view.q[0] == 0.5, "a turned arm")
    type_in(page, "joint2", "-0.5")
    wait_to_see(page, lambda: view.q[1] == -0.5, "a bent arm")
    wait_to_see(page, lambda: view.obstacles.history.can_undo and view._last_event_time is None, "a step to undo")
    view.q = panda.home + 0.1
    page.wait_for_timeout(800)
    page.get_by_role("button", name="Undo").click()
    wait_to_see(page, lambda: view.q[0] == 0.0 or view.q[1] == panda.home[1], "the arm before")


def test_a_clicked_link_says_what_it_is_is_hidden_narrowed_and_carries_an_obstacle(view, page, panda):
    camera = camera_of(page, view.page.server)
    elbow = panda.forward_kinematics(panda.home, link="panda_link3")[:3, 3]

    def click():
        page.mouse.click(*project(camera, elbow))
        page.wait_for_timeout(3000)

    link = wait_for(lambda: view.link.chosen, "a chosen link", pause=click)
    page.get_by_role("button", name=link).wait_for()
    joint = next(joint for joint in panda.description.joints if joint.child == link)
    page.get_by_text(f"{joint.name} (revolute)").wait_for()
    page.get_by_role("button", name="Hide this link").click()
    wait_to_see(page, lambda: not view.arm.looks[link].visible, "a hidden link")
    page.get_by_role("button", name="Limits of its joint").click()
    column = panda.joint_names.index(joint.name)
    most = round(panda.upper[column] - 0.05, 2)
    type_in(page, "Upper limit", f"{most}")
    wait_to_see(page, lambda: view.session.robot.upper[column] == most, "a narrower limit")
    wait_to_see(page, lambda: view.joints.sliders[column][1].max == most, "its slider")
    page.get_by_role("tab", name="Obstacles").click()
    page.get_by_label("Obstacle", exact=True).click()
    page.get_by_role("option", name="crate").click()
    page.get_by_role("button", name="Attach crate").click()
    wait_to_see(page, lambda: view.session.robot.attached and not view.world.names, "an attached crate")
    before = wait_to_see(page, lambda: view.arm.attached.get("crate"), "the crate on the arm")
    page.get_by_text("Attached: crate to").wait_for()
    type_in(page, "Mass of crate [kg]", "2.5")
    wait_to_see(page, lambda: view.session.robot.attached[0].inertia, "a crate with a mass")
    page.get_by_text("with 2.5 kg").wait_for()
    one = view.session.robot.attached[0]
    held = panda.with_attached(one.name, one.shape, one.T_link_object, link=one.link, mass=2.5)
    assert np.array_equal(view.session.robot.gravity_torque(panda.home), held.gravity_torque(panda.home))
    page.get_by_role("button", name="Put crate down").click()
    wait_to_see(page, lambda: not view.session.robot.attached and view.world.names == ("crate",), "a crate that is put down")
    np.testing.assert_allclose(view.world.pose("crate"), ulna.pose((0.5, -0.4, 0.05)), atol=1e-12)
    wait_to_see(page, lambda: before not in view.arm.attached.values(), "an arm without the crate")
    history = view.obstacles.history
    for left in (4, 3, 2, 1, 0):
        page.get_by_role("button", name="Undo").click()
        wait_to_see(page, lambda left=left: history._n_done == left, "a step less")
    wait_to_see(page, lambda: view.session.robot is panda and view.arm.looks[link].visible, "the arm as it was")
    assert view.world.names == ("crate",)


def test_contacts_of_a_link_with_an_obstacle_are_allowed(view, page, panda):
    view.world.move("crate", panda.forward_kinematics(panda.home, link="panda_link7"))
    wait_for(lambda: view.session.clearance.state == "collision", "a collision", looks=None)
    page.get_by_role("tab", name="Look").click()
    for _ in range(6):
        report = view.session.clearance.report
        hits = [pair.link_a for pair in report.pairs if pair.signed_distance <= 0.0 and pair.link_b is None]
        if not hits:
            break
        page.get_by_label("Link", exact=True).click()
        page.get_by_role("option", name=hits[0], exact=True).click()
        page.get_by_role("button", name="Allow contact with").click()
        wait_to_see(page, lambda link=hits[0]: link in view.world.touch_links("crate"), "a link that may touch")
        wait_to_see(page, lambda known=report: view.session.clearance.report is not known, "another check")
    wait_to_see(page, lambda: view.session.clearance.state == "free", "no collision")


def test_a_picture_of_the_scene_is_saved(view, page):
    page.get_by_role("tab", name="Look").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save picture").click()
    picture = np.asarray(Image.open(io.BytesIO(download.value.path().read_bytes())))
    assert picture.shape[2] == 3
    assert picture.shape[0] > 200
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 500, "the arm and the sky"


def test_handles_are_shown_in_the_tab_to_which_they_belong(view, page):
    hand, chosen = view.hand.handles.control, view.obstacles.handles.control
    wait_to_see(page, lambda: hand.visible, "the handles of the hand")
    page.get_by_role("tab", name="Obstacles").click()
    wait_to_see(page, lambda: not hand.visible, "no handles of the hand")
    with view.obstacles.lock:
        view.obstacles.form.choose("crate")
    view._on_event()
    wait_to_see(page, lambda: chosen.visible, "the handles of the obstacle")
    page.get_by_role("tab", name="Steer").click()
    wait_to_see(page, lambda: not hand.visible and not chosen.visible, "no handles")


def test_a_gamepad_holds_the_buttons_of_the_pad(view, page, panda):
    page.get_by_role("tab", name="Steer").click()
    page.get_by_role("button", name="Steer the hand").click()
    wait_to_see(page, lambda: view.steer.steering.can_move, "an arm that can be steered")
    page.evaluate("""() => {
        window.pad = { connected: true, axes: [0, 0, 0, -1], buttons: Array(17).fill({ pressed: false }) };
        navigator.getGamepads = () => [window.pad];
        dispatchEvent(new Event('gamepadconnected'));
    }""")
    before = panda.forward_kinematics(view.q)[:3, 3]
    wait_to_see(page, lambda: panda.forward_kinematics(view.q)[2, 3] > before[2] + 0.01, "a hand that rises")
    page.evaluate("window.pad.axes = [0, 0, 0, 0]")
    wait_to_see(page, lambda: not view.steer.moving, "a hand that rests")


def test_folders_are_opened_by_keys(page):
    title = page.get_by_role("button", name="Copy, save, load q")
    title.focus()
    assert title.get_attribute("aria-expanded") == "false"
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Save q").wait_for()
    wait_to_see(page, lambda: title.get_attribute("aria-expanded") == "true", "an open folder")
