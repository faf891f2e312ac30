"""Videos and pictures of the demo, decoded again and compared with the collision checker."""

from itertools import product

import numpy as np
import pytest
from PIL import Image

from browser import around
from colors import count
from matrix import matrix
from ulna.collision.world import World
from ulna.demo.drawing import box_handles
from ulna.demo.film import DEMO_CAMERA, Script, record_demo
from ulna.demo.scenario import BOX, LIGHT_POSITION, Demo
from ulna.description.pose import pose
from ulna.robot import load
from ulna.viewer.film.recording import make_form
from videos import decoded

SIZE = (320, 180)


def light_of(pixels):
    """The color of the light in a picture: where the camera sees it."""
    height, width = pixels.shape[:2]
    square = around(pixels.astype(int), DEMO_CAMERA.place(LIGHT_POSITION, width, height), 4)
    (color,) = (color for color in ("red", "green") if count(square, color) > 0.9 * square[..., 0].size)
    return color


def expected_lights(seconds, rate):
    """The color of the light at each frame's time, by a collision check in a world made here."""
    demo, robot, lights = Demo(), load("panda"), []
    story = Script(demo, seconds)
    for k in range(round(seconds * rate)):
        world = World()
        world.add("crate", BOX, story.box_pose(k / rate / seconds))
        q = demo.trajectory.at(k / rate)
        lights.append("red" if robot.in_collision(q, world, self_collision=False) else "green")
    return lights


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "demo.mp4"
    record_demo(make_form(path, 6.0, SIZE, 10))
    return path


@pytest.mark.slow
def test_a_video_has_the_requested_length_size_and_a_browser_format(video):
    frames, codec, pixel_format, rate, seconds = decoded(video)
    assert len(frames) == 60
    assert {frame.shape for frame in frames} == {(180, 320, 3)}
    assert (codec, pixel_format, rate) == ("h264", "yuv420p", 10.0)
    assert seconds == pytest.approx(6.0, abs=0.05)
    with video.open("rb") as file:
        assert b"moov" in file.read(4096), "a page begins to play it before it is there as a whole"


def test_the_light_is_red_in_the_frames_in_which_the_checker_finds_a_collision(video):
    lights = expected_lights(6.0, 10)
    assert [light_of(frame) for frame in decoded(video)[0]] == lights
    assert 6 < lights.count("red") < 54


@pytest.mark.slow
def test_a_gif_has_the_requested_length_and_the_same_lights(tmp_path):
    path = tmp_path / "demo.gif"
    record_demo(make_form(path, 3.0, SIZE, 15))
    lights, total = [], 0
    with Image.open(path) as image:
        assert image.size == SIZE
        assert image.info["loop"] == 0
        for k in range(image.n_frames):
            image.seek(k)
            total += image.info["duration"]
            lights.append(light_of(np.asarray(image.convert("RGB"))))
    assert total == 3000
    assert lights == expected_lights(3.0, 15)


@pytest.mark.slow
def test_a_png_shows_the_requested_time(tmp_path):
    path = tmp_path / "demo.png"
    seen = {}
    for at in (0.0, 3.0):
        record_demo(make_form(path, 30.0, SIZE), at)
        with Image.open(path) as image:
            seen[at] = light_of(np.asarray(image.convert("RGB")))
    assert seen == {0.0: "green", 3.0: "red"}


@pytest.mark.slow
def test_two_runs_write_the_same_file(video, tmp_path):
    record_demo(make_form(tmp_path / "again.mp4", 6.0, SIZE, 10))
    assert (tmp_path / "again.mp4").read_bytes() == video.read_bytes()


@pytest.mark.slow
def test_width_and_height_of_a_video_are_rounded_up_to_even_numbers(tmp_path):
    record_demo(make_form(tmp_path / "odd.mp4", 0.2, (161, 91), 10))
    assert {frame.shape for frame in decoded(tmp_path / "odd.mp4")[0]} == {(92, 162, 3)}


@pytest.mark.slow
@pytest.mark.parametrize("size", matrix([(200, 200), (90, 320), (400, 100)], [(90, 320)]))
def test_a_picture_of_any_aspect_ratio_shows_the_box_and_the_light(tmp_path, size):
    path = tmp_path / "demo.png"
    record_demo(make_form(path, 30.0, size), 0.0)
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert count(pixels, "green") > 10
    orange = (pixels[..., 0] > 150) & (pixels[..., 2] < 80) & (pixels[..., 1] > 90)
    assert np.count_nonzero(orange) > 10


def test_the_box_is_in_the_picture_in_every_frame():
    story = Script(Demo(), 30.0)
    corners = np.array(list(product((-1, 1), repeat=3))) * BOX.half_extents
    for k in range(900):
        T = story.box_pose(k / 900)
        for corner in corners:
            x, y = DEMO_CAMERA.place(T[:3, :3] @ corner + T[:3, 3], 1280, 720)
            assert 0 < x < 1280
            assert 0 < y < 720


def test_the_arrows_of_the_box_point_along_its_axes():
    T = pose((0.4, 0.1, 0.5), (0.3, 0.4, 0.5))
    heads = {solid.name[7]: solid.pose[:3, 3] - T[:3, 3] for solid in box_handles(load("panda"), T) if "head" in solid.name}
    for k, axis in enumerate("xyz"):
        assert np.allclose(heads[axis], 0.2 * T[:3, k])
