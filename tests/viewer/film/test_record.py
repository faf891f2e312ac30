"""Videos and pictures of a robot, decoded again: the robot is where forward kinematics puts it."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ulna.errors import FileError, InputError
from ulna.robot import load
from ulna.viewer.film.recording import make_form, record_robot
from videos import decoded

SIZE = (320, 180)


@pytest.mark.slow
def test_a_turning_camera_keeps_the_robot_in_the_picture(tmp_path):
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


@pytest.mark.process
def test_a_video_needs_no_display_and_no_graphics_library(tmp_path):
    """The environment is empty; on Linux, the list of loaded libraries is checked."""
    program = (
        "import sys; from pathlib import Path; from ulna.viewer.film.recording import *; from ulna.robot import load;"
        "panda = load('panda'); record_robot(make_form(Path(sys.argv[1]), 0.2, (160, 90), 10), panda, panda.home);"
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
        ("panda.avi", {}, "path: 'panda.avi' ends in none of .mp4, .gif, .png"),
        ("panda", {}, "path: 'panda' ends in none of"),
        ("panda.mp4", {"size": (8, 100)}, "size: 8x100; each side has 16 to 4096 pixels"),
        ("panda.mp4", {"size": (100, 4097)}, "size: 100x4097"),
        ("panda.gif", {"rate": 51}, "rate: 51; 1 to 50"),
        ("panda.mp4", {"rate": 0}, "rate: 0; 1 to 120"),
        ("panda.mp4", {"rate": 121}, "rate: 121; 1 to 120"),
        ("panda.mp4", {"seconds": 0.0}, "seconds: 0; a length above 0 s"),
        ("panda.mp4", {"seconds": float("nan")}, "seconds: nan"),
        ("panda.mp4", {"seconds": 1e9}, "seconds: 1e\\+09"),
    ],
)
def test_an_impossible_size_rate_or_format_is_refused(tmp_path, name, form, message):
    with pytest.raises(InputError, match=message):
        make_form(tmp_path / name, **({"seconds": 1.0} | form))


@pytest.mark.slow
@pytest.mark.parametrize("place", ["missing/panda.png", "file/panda.png", "folder.png"])
def test_a_file_that_cannot_be_written_is_an_error_with_its_path(tmp_path, place, panda):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(FileError, match=rf"{place}: cannot be written: "):
        record_robot(make_form(tmp_path / place, 1.0, (32, 32)), panda, panda.home)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder.png"]
