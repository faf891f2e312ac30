"""``ulna ros1 record``: a video of real RViz, in which the pointer drags the box and the light turns red and green again."""

import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip("rospy", reason="no ROS 1 for this Python: docs/ros.md says how to install it")
from colors import count
from ulna.demo.ros.rviz_view import BACKGROUND, View
from ulna.demo.scenario import BOX_START, LIGHT_POSITION
from videos import decoded

pytestmark = pytest.mark.filterwarnings(
    "ignore:unclosed:ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # rospy's


def record(environment, path, *words):
    command = [sys.executable, "-m", "ulna", "ros1", "record", str(path), *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_the_light_in_the_video_turns_red_and_green_again(another, tmp_path):
    done = record(another, tmp_path / "out.mp4", "--seconds", "4")
    assert done.returncode == 0, done.stderr
    frames, codec, _, rate, _ = decoded(tmp_path / "out.mp4")
    assert (codec, rate, len(frames), frames[0].shape) == ("h264", 10.0, 40, (800, 1280, 3))
    view = View(exact(frames[0]))
    lights = [view.around(frame.astype(int), LIGHT_POSITION, 12) for frame in frames]
    colors = ["red" if count(light, "red") > 200 else "green" if count(light, "green") > 200 else "" for light in lights]
    assert colors[0] == colors[-1] == "green"
    assert "red" in colors
    above = np.add(BOX_START, (0, 0, 0.26))  # where the first drag ends
    brown = [np.count_nonzero(is_box(view.around(frame, above, 25))) for frame in frames]
    assert brown[0] < 100
    assert max(brown) > 400


def exact(frame):
    """The frame with the exact background colour, which the encoder changes a little, and black elsewhere."""
    near = np.abs(frame.astype(int) - BACKGROUND).max(axis=-1) <= 4
    near &= near.sum(axis=0) > 300  # not what is pale in the windows beside
    rows = np.flatnonzero(near.sum(axis=1) > 300)
    rows = max(np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1), key=len)  # nor above
    near[: rows[0]] = near[rows[-1] + 1 :] = False
    return np.where(near[..., None], BACKGROUND, 0)


def is_box(pixels):
    r, _, b = np.moveaxis(pixels.astype(int), -1, 0)
    return (r > 90) & (r - b > 60)


def test_missing_programs_are_named_with_their_packages(another, tmp_path):
    nothing = tmp_path / "bin"
    nothing.mkdir()
    done = record(another | {"PATH": str(nothing)}, tmp_path / "out.mp4")
    assert done.returncode == 2
    assert "apt-get install python3-rosmaster rviz xvfb xdotool" in done.stderr
    assert not list(tmp_path.glob("*.mp4"))
