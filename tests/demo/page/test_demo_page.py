import asyncio
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import av
import numpy as np
import pytest

from browser import SIZE, around, camera_of, pixels, project, wait_to_see
from colors import count
from processes import wait_for
from ulna.demo.page import DemoApp, serve
from ulna.demo.scenario import BOX_NAME, BOX_START, LIGHT_POSITION, Demo
from ulna.description.pose import pose


@pytest.fixture
def app():
    app = DemoApp(Demo(), port=0)
    yield app
    app.stop()


@pytest.fixture
def page(app, open_page):
    page = open_page(app.url)
    page.get_by_text("free", exact=True).first.wait_for()
    wait_to_see(page, app.server.get_clients, "the page's connection")
    return page


@pytest.fixture
def still(app, page):
    """The camera of the only tab, after the arm is at home and the box at its start."""
    app.set_configuration(app.demo.robot.home)
    page.get_by_role("button", name="Put the box back").click()
    wait_to_see(page, lambda: np.allclose(app.scene.handles.control.position, BOX_START), "the box at its start")
    camera = camera_of(page, app.server)
    wait_to_see(page, lambda: light_is(page, camera, "green"), "a green light")
    return camera


def light_is(page, camera, color):
    square = around(pixels(page), project(camera, LIGHT_POSITION), 12)
    return count(square, color) > 200


def test_the_arm_is_drawn_where_forward_kinematics_puts_it(app, page, still):
    page.get_by_role("checkbox", name="Boxes").uncheck()
    wrist, hand = (app.demo.robot.forward_kinematics(app.player.q, link=link)[:3, 3] for link in ("panda_link6", "panda_link8"))

    def arm_is_there(image):
        return all(np.count_nonzero(around(image, project(still, p), 10).max(axis=-1) < 215) > 200 for p in (wrist, hand))

    wait_to_see(page, lambda: arm_is_there(pixels(page)), "the arm")
    app.set_configuration(app.demo.robot.home + np.array([2.5, 0, 0, 0, 0, 0, 0]))
    wait_to_see(page, lambda: not arm_is_there(pixels(page)), "the arm gone from there")
    page.get_by_role("checkbox", name="Boxes").check()


def test_the_light_is_red_while_the_box_is_dragged_into_the_arm(app, page, still):
    app.set_configuration(app.demo.trajectory.samples[30])  # the hand is above the box
    image = pixels(page)
    start = project(still, BOX_START)
    blue = image[..., 2] - image[..., :2].max(axis=-1) > 60
    rows, columns = np.nonzero(blue[: round(start[1]), round(start[0]) - 40 : round(start[0]) + 40])
    tip = (round(start[0]) - 40 + int(columns[rows.argmin()]), int(rows.min()) + 12)  # the head of the arrow that points up

    page.mouse.move(*tip)
    page.mouse.down()
    for climb in range(0, 130, 10):
        page.mouse.move(tip[0], tip[1] - climb)
        page.wait_for_timeout(50)
    wait_to_see(page, lambda: app.scene.handles.control.position[2] > BOX_START[2] + 0.1, "the box above")
    wait_to_see(page, lambda: light_is(page, still, "red"), "a red light")
    assert np.allclose(app.scene.handles.control.position[:2], BOX_START[:2], atol=1e-3)
    assert app.player.response_time > 0.0

    def text_names_the_touching_boxes():
        return page.get_by_role("status").inner_text().strip() == f"collision: {', '.join(app.demo.check(app.player.q).touching)}"

    wait_to_see(page, text_names_the_touching_boxes, "what touches, in words")
    assert "box 12" in app.demo.check(app.player.q).touching
    assert app.scene.arm.solids["box 12"].color == (225, 45, 45)

    for climb in range(130, -1, -10):
        page.mouse.move(tip[0], tip[1] - climb)
        page.wait_for_timeout(50)
    page.mouse.up()
    wait_to_see(page, lambda: not app.scene.handles.dragged, "a box that is let go")
    wait_to_see(page, lambda: light_is(page, still, "green"), "a green light again")
    wait_to_see(page, lambda: page.get_by_role("status").inner_text().strip() == "free", "the word free")
    assert app.scene.arm.solids["box 12"].color != (225, 45, 45)


def test_play_moves_the_arm_and_a_slider_stops_it(app, page, still):
    page.get_by_role("checkbox", name="Play").check()
    wait_to_see(page, lambda: not np.allclose(app.player.q, app.demo.robot.home, atol=0.01), "a moving arm")
    box = page.get_by_role("textbox").nth(1)
    box.click()
    box.press("Control+a")
    box.press_sequentially("1.5", delay=150)  # as slowly as a person: the arm plays on meanwhile
    box.press("Enter")
    wait_to_see(page, lambda: not app.playing.value and app.player.q[0] == pytest.approx(1.5), "joint 1 where the slider is")
    page.wait_for_timeout(1000)
    assert app.player.q[0] == pytest.approx(1.5)
    wait_to_see(page, lambda: not page.get_by_role("checkbox", name="Play").is_checked(), "the box Play unchecked")


def test_the_list_of_keys_has_those_of_the_demo_alone(page):
    """It has neither the tab Steer nor undo."""
    page.locator("canvas").first.press("?")
    keys = page.get_by_role("dialog", name="Keys")
    keys.wait_for()
    assert "Drag an obstacle" in keys.inner_text()
    assert not any(word in keys.inner_text() for word in ("Steer", "undo", "Gamepad"))


def test_on_a_phone_the_box_the_light_and_the_hand_are_above_the_panel(app, open_page):
    page = open_page(app.url, size=(390, 844))
    camera = camera_of(page, app.server)
    hand = app.demo.robot.forward_kinematics(app.demo.robot.home)[:3, 3]

    def all_in_sight():
        width, height = page.evaluate(
            "(({width, height}) => [width, height])(document.querySelector('canvas').getBoundingClientRect())"
        )
        top = page.get_by_role("status").bounding_box()["y"]
        seen = np.array([project(camera, point) for point in (BOX_START, LIGHT_POSITION, hand)])
        return height < top and (seen > 10).all() and (seen < (width - 10, height - 10)).all()

    wait_to_see(page, all_in_sight, "the box, the light and the hand")
    assert page.title() == "panda - Ulna demo"


def test_the_page_loads_nothing_from_other_hosts(page):
    assert page.addresses
    assert all(address.startswith(("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:")) for address in page.addresses)


# A separate program, in which no kernel is loaded. It cannot compile while another thread holds Numba's lock.
HELD = """
from numba.core.compiler_lock import global_compiler_lock
from processes import wait_for
from ulna.demo.page import DemoApp
from ulna.demo.scenario import Demo
from ulna.viewer.palette import GREEN, UNKNOWN

demo = Demo()
demo.robot.link_poses(demo.robot.home)  # all that the first picture needs
with global_compiler_lock:
    app = DemoApp(demo, port=0)
    wait_for(lambda: "Compiling for this machine (once): " in app.notice.text, "the word of it")
    assert app.scene.light.color == UNKNOWN
    assert "compiling ..." in app.verdict.content
app.wait_until_compiled()
wait_for(lambda: app.scene.light.color == GREEN, "a light that knows", looks=None)
wait_for(lambda: app.player.time > 0, "an arm that moves", looks=None)
app.stop()
print("done")
"""


@pytest.mark.process
@pytest.mark.compiler
def test_the_light_is_grey_until_the_collision_check_is_compiled():
    path = ":".join(sys.path)
    done = subprocess.run([sys.executable, "-c", HELD], env={"PYTHONPATH": path}, capture_output=True, text=True, check=False)
    assert done.stdout == "done\n", done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("passed", [True, False])
def test_the_page_opens_before_the_checks_and_closes_if_one_fails(passed, monkeypatch, capsys):
    seen = []

    def meanwhile():
        seen.append(capsys.readouterr().out)
        return passed

    monkeypatch.setattr(DemoApp, "wait", lambda _: seen.append("waits"))
    assert serve(Demo(), port=0, open_browser=False, meanwhile=meanwhile) == passed
    assert seen[0].startswith("The Panda is at http://127.0.0.1:")
    assert ("waits" in seen) == passed


def test_stopping_leaves_no_thread_behind():
    before = threading.active_count()
    app = DemoApp(Demo(), port=0)
    app.stop()
    wait_for(lambda: threading.active_count() <= before, "no thread left")


def test_a_demo_that_cannot_be_built_leaves_no_thread(monkeypatch):
    before = threading.active_count()
    monkeypatch.setitem(DemoApp._build.__globals__, "DemoScene", lambda *_: 1 / 0)  # another test forgets modules
    with pytest.raises(ZeroDivisionError):
        DemoApp(Demo(), port=0)
    wait_for(lambda: threading.active_count() <= before, "no thread left")


def test_the_collision_check_uses_the_latest_position_of_the_handles(app):
    """Events of a drag that arrive during a frame are not lost."""
    handles = app.scene.handles
    for x in (0.3, 0.6, 0.45):
        with app.player.lock:  # a frame is being made
            for step in (0.0, 0.01):
                handles.control.position = np.array([x + step, 0.0, 0.5])
                event = handles._update(SimpleNamespace(phase="update", client_id=0))
                asyncio.run_coroutine_threadsafe(event, app.server._event_loop).result(10)
        wait_for(lambda: not handles.moved_by_hand, "a frame")
        with app.player.lock:
            assert np.array_equal(app.demo.world.pose(BOX_NAME), handles.pose)


@pytest.mark.slow
def test_record_downloads_a_video_of_the_page(app, page, still):
    """In the video the light is where the page's camera shows it, and turns red when the box is moved."""
    before = time.monotonic()
    page.get_by_role("button", name="Record").click()
    wait_to_see(page, lambda: len(app.recording._shots) >= 20, "twenty shots")
    app.put_box(pose((0.3, 0.0, 0.5)))
    shots = len(app.recording._shots)
    wait_to_see(page, lambda: len(app.recording._shots) >= shots + 20, "twenty more")
    page.get_by_role("button", name="Stop recording").click()
    wait_to_see(page, lambda: app.recording._client is None, "the end of the recording")
    seconds = time.monotonic() - before
    with page.expect_download() as download:
        page.get_by_text("ulna-demo.mp4 (").first.click()  # the link with the size, once the video is made
    with av.open(str(download.value.path())) as container:
        frames = [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(video=0)]
    assert 30 <= len(frames) <= 30 * seconds + 1  # as long as it was recorded
    assert frames[0].shape[1] / frames[0].shape[0] == pytest.approx(still.image_width / still.image_height, rel=0.02)
    scale = frames[0].shape[0] / SIZE[1]
    place = [scale * along for along in project(still, LIGHT_POSITION)]
    colors = [max(("green", "red"), key=lambda color: count(around(frame, place, 8), color)) for frame in (frames[0], frames[-1])]
    assert colors == ["green", "red"]
    page.get_by_role("button", name="Record").wait_for()


@pytest.mark.slow
def test_the_sliders_follow_the_playing_arm(app, page, still):
    field = page.get_by_role("textbox", name="joint2")
    app.playing.value = True
    seen = set()

    def several():
        seen.add(field.input_value())
        return len(seen) > 3

    wait_to_see(page, several, "joint 2 on its way")
    page.get_by_role("checkbox", name="Play").uncheck()
    wait_to_see(page, lambda: not app.playing.value, "an arm at rest")
    wait_to_see(page, lambda: float(field.input_value()) == pytest.approx(app.player.q[1], abs=6e-4), "joint 2 where the arm is")
