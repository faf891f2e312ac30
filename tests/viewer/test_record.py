"""Videos and pictures, read again and looked at: what is seen is held against the collision checker and forward kinematics."""

import os
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from browser import around
from colors import count
from ulna.collision.world import World
from ulna.demo.film import DEMO_CAMERA, record_demo
from ulna.demo.scenario import BOX, LIGHT_POSITION, Demo
from ulna.demo.script import Story
from ulna.errors import FileError, InputError
from ulna.robot import load
from ulna.viewer.film.record import make_form, record_robot

SIZE = (320, 180)


def decoded(path):
    """The frames of a video as pixels, and what its stream says."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        return (
            frames,
            stream.codec_context.name,
            stream.codec_context.pix_fmt,
            float(stream.average_rate),
            container.duration / 1e6,
        )


def light_of(pixels):
    """The colour of the light in a picture: where the camera sees it."""
    height, width = pixels.shape[:2]
    square = around(pixels.astype(int), DEMO_CAMERA.place(LIGHT_POSITION, width, height), 4)
    (color,) = (color for color in ("red", "green") if count(square, color) > 0.9 * square[..., 0].size)
    return color


def expected_lights(seconds, rate):
    """What the checker says, asked anew: at each frame's time, in a world of its own."""
    demo, robot, lights = Demo(), load("panda"), []
    story = Story(demo, seconds)
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


def test_a_video_has_its_frames_its_size_and_plays_in_browsers(video):
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


def test_a_moving_picture_lasts_as_long_and_has_the_same_lights(tmp_path):
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


def test_a_picture_shows_the_moment_that_is_asked_for(tmp_path):
    path = tmp_path / "demo.png"
    seen = {}
    for at in (0.0, 3.0):
        record_demo(make_form(path, 30.0, SIZE), at)
        with Image.open(path) as image:
            seen[at] = light_of(np.asarray(image.convert("RGB")))
    assert seen == {0.0: "green", 3.0: "red"}


def test_the_same_command_makes_the_same_file(video, tmp_path):
    record_demo(make_form(tmp_path / "again.mp4", 6.0, SIZE, 10))
    assert (tmp_path / "again.mp4").read_bytes() == video.read_bytes()


def test_the_sides_of_a_video_are_made_even(tmp_path):
    record_demo(make_form(tmp_path / "odd.mp4", 0.2, (161, 91), 10))
    assert {frame.shape for frame in decoded(tmp_path / "odd.mp4")[0]} == {(92, 162, 3)}


@pytest.mark.parametrize("size", [(200, 200), (90, 320), (400, 100)])
def test_a_picture_of_any_shape_shows_the_arm_the_box_and_the_light(tmp_path, size):
    path = tmp_path / "demo.png"
    record_demo(make_form(path, 30.0, size), 0.0)
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert count(pixels, "green") > 10
    orange = (pixels[..., 0] > 150) & (pixels[..., 2] < 80) & (pixels[..., 1] > 90)
    assert np.count_nonzero(orange) > 10


def test_a_robot_is_seen_where_forward_kinematics_puts_it_from_all_sides(tmp_path):
    robot = load("panda")
    path = tmp_path / "panda.mp4"
    record_robot(make_form(path, 1.0, SIZE, 8), robot, robot.home + 0.2, boxes=False)
    frames, *_ = decoded(path)
    assert len(frames) == 8
    for frame in frames:
        rows, columns = np.nonzero(frame.min(axis=-1) < 100)  # its dark joints
        assert rows.size > 20
        assert rows.min() > 5
        assert rows.max() < 175
        assert columns.min() > 5
        assert columns.max() < 315


def test_it_is_made_with_no_display_and_no_graphics_library(tmp_path):
    """In an empty environment, and what the process has loaded is looked at: Linux tells."""
    program = (
        "import sys; from pathlib import Path; from ulna.viewer.film.record import *;"
        "record_demo(make_form(Path(sys.argv[1]), 0.2, (160, 90), 10));"
        "print(Path('/proc/self/maps').read_text() if sys.platform == 'linux' else '')"
    )
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "HOME": str(Path.home())}
    command = [sys.executable, "-c", program, str(tmp_path / "bare.mp4")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert len(decoded(tmp_path / "bare.mp4")[0]) == 2
    of_the_system = [line for line in done.stdout.splitlines() if "site-packages" not in line]
    for library in ("libGL", "libEGL", "libOSMesa", "libvulkan", "libX11", "libxcb", "libwayland", "libcuda"):
        assert not [line for line in of_the_system if f"/{library}" in line], library


@pytest.mark.parametrize(
    ("name", "form", "message"),
    [
        ("demo.avi", {}, "path: 'demo.avi' ends in none of .mp4, .gif, .png"),
        ("demo", {}, "path: 'demo' ends in none of"),
        ("demo.mp4", {"size": (8, 100)}, "size: 8x100; each side has 16 to 4096 pixels"),
        ("demo.mp4", {"size": (100, 4097)}, "size: 100x4097"),
        ("demo.gif", {"rate": 51}, "rate: 51; 1 to 50"),
        ("demo.mp4", {"rate": 0}, "rate: 0; 1 to 120"),
        ("demo.mp4", {"rate": 121}, "rate: 121; 1 to 120"),
        ("demo.mp4", {"seconds": 0.0}, "seconds: 0; more than 0 s"),
        ("demo.mp4", {"seconds": float("nan")}, "seconds: nan"),
        ("demo.mp4", {"seconds": 1e9}, "seconds: 1e\\+09"),
    ],
)
def test_a_form_that_cannot_be_had_is_refused(tmp_path, name, form, message):
    with pytest.raises(InputError, match=message):
        make_form(tmp_path / name, **({"seconds": 1.0} | form))


@pytest.mark.parametrize("place", ["missing/demo.png", "file/demo.png", "folder.png"])
def test_a_file_that_cannot_be_written_is_an_error_that_names_it(tmp_path, place):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(FileError, match=rf"{place}: cannot be written: "):
        record_demo(make_form(tmp_path / place, 1.0, (32, 32)))
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder.png"]
