"""``ulna ros1 record``: a video of real RViz, in which the pointer drags the box and the light turns red and green again."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rospy", reason="no ROS 1 for this Python: docs/ros.md says how to install it")
from colors import count
from processes import wait_for
from ulna.demo.ros.screen import BACKGROUND, View
from ulna.demo.scenario import BOX_START, LIGHT_POSITION
from videos import decoded

pytestmark = pytest.mark.filterwarnings(
    "ignore:unclosed:ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"
)  # rospy's


def record(environment, path, *words, meanwhile=lambda _: None):
    command = [sys.executable, "-m", "ulna", "ros1", "record", str(path), *words]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        meanwhile(process)
        return process, process.communicate()[1]


def children(parent, name):
    """The numbers of the processes of that name that a process has started."""
    listed = Path(f"/proc/{parent}/task/{parent}/children")
    numbers = listed.read_text().split() if listed.exists() else []
    return [int(number) for number in numbers if Path(f"/proc/{number}/comm").read_text().strip() == name]


def stall_rviz(process):
    """Stop RViz for 2.7 seconds of 4.7, until the process ends: as on a machine that is busy with other programs."""
    while process.poll() is None:
        for number in children(process.pid, "rviz"):
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(number, signal.SIGSTOP)
                time.sleep(2.7)
                os.kill(number, signal.SIGCONT)
        time.sleep(2.0)


def crash_rviz(process):
    """End the first RViz by a fault."""
    first = wait_for(lambda: process.poll() is not None or children(process.pid, "rviz"), "RViz")
    os.kill(first[0], signal.SIGSEGV)


@pytest.mark.parametrize("meanwhile", [lambda _: None, stall_rviz, crash_rviz], ids=["idle", "stalled", "crashed"])
def test_the_light_in_the_video_turns_red_and_green_again(another, tmp_path, meanwhile):
    process, errors = record(another, tmp_path / "out.mp4", "--seconds", "6", meanwhile=meanwhile)
    assert process.returncode == 0, errors
    frames, codec, _, rate, _ = decoded(tmp_path / "out.mp4")
    assert (codec, rate, len(frames), frames[0].shape) == ("h264", 10.0, 60, (800, 1280, 3))
    view = View(exact(frames[0]))
    lights = [view.around(frame.astype(int), LIGHT_POSITION, 12) for frame in frames]
    colors = ["red" if count(light, "red") > 200 else "green" if count(light, "green") > 200 else "" for light in lights]
    assert colors[0] == colors[-1] == "green"
    assert "red" in colors
    above = np.add(BOX_START, (0, 0, 0.35))  # where the first drag ends
    brown = [np.count_nonzero(is_box(view.around(frame, above, 25))) for frame in frames]
    assert brown[0] < 100
    assert max(brown) > 400


def exact(frame):
    """The frame with the exact background color, which the encoder changes a little, and black elsewhere."""
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
    process, errors = record(another | {"PATH": str(nothing)}, tmp_path / "out.mp4")
    assert process.returncode == 2
    assert "apt-get install python3-rosmaster rviz xvfb xdotool" in errors
    assert not list(tmp_path.glob("*.mp4"))
