"""Without ROS: an error of one line, which names the command that works without it."""

import importlib.util
import os
import runpy
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna.demo.drawing import standing_boxes
from ulna.demo.ros.adapter import load_ros
from ulna.demo.ros.description import robot_description, with_fingers
from ulna.errors import MissingROSError

ROOT = Path(__file__).parents[3]
SENTENCE = "is not available (this Python has no module 'r"
SAME = "the same in the browser, without ROS: ulna demo"
SCRIPTS = ("test_collision_boxes.py", "collision_boxes.py", "test_collision_detection.py", "6DoF_Box.py")


pytestmark = pytest.mark.skipif(importlib.util.find_spec("rosgraph") is not None, reason="ROS is here")


@pytest.mark.process
@pytest.mark.parametrize("script", SCRIPTS)
def test_a_script_of_hw2_without_ros_is_a_one_line_error(script):
    run = subprocess.run([sys.executable, script], cwd=ROOT / "hw2", capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert SENTENCE in run.stderr
    assert SAME in run.stderr
    assert len(run.stderr.splitlines()) == 1


@pytest.mark.process
@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to send to oneself")
def test_ctrl_c_while_ros_is_imported_ends_a_script_without_a_traceback(tmp_path):
    (tmp_path / "rosgraph.py").write_text("import signal; signal.raise_signal(signal.SIGINT)")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "test_collision_detection.py"]
    run = subprocess.run(command, cwd=ROOT / "hw2", env=environment, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (130, "")


@pytest.mark.process
@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to send to oneself")
@pytest.mark.parametrize("script", sorted({path.name for path in (ROOT / "hw2").glob("*.py")} - {"franka_robot.py", "panda.py"}))
def test_ctrl_c_in_the_first_import_ends_a_script_without_a_traceback(script, tmp_path):
    (tmp_path / "numpy.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = ["sh", "-c", f"'{sys.executable}' {script}; exit $?"]  # what a shell says of an end by a signal
    run = subprocess.run(command, cwd=ROOT / "hw2", env=environment, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (130, "")


@pytest.mark.process
@pytest.mark.parametrize("version", ["ros1", "ros2"])
def test_a_ros_command_without_ros_is_a_one_line_error(version):
    run = subprocess.run([sys.executable, "-m", "ulna", version, "demo"], capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert run.stderr.startswith(f"ulna: ROS {version[-1]} {SENTENCE}")
    assert run.stderr.rstrip().endswith(SAME)


def test_a_failed_import_of_ros_is_quoted(tmp_path, monkeypatch):
    (tmp_path / "rosgraph.py").write_text('raise ImportError("libros.so:\\n cannot open")')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    with pytest.raises(MissingROSError, match=r"\(it cannot be imported: libros.so: cannot open; docs/ros.md explains"):
        load_ros(1)


def test_ros_uses_the_loopback_address_unless_the_user_set_another(monkeypatch):
    monkeypatch.setenv("ROS_IP", "")
    monkeypatch.setenv("ROS_HOSTNAME", "")
    with pytest.raises(MissingROSError):
        load_ros(1)
    assert os.environ["ROS_IP"] == "127.0.0.1"
    monkeypatch.setenv("ROS_IP", "")
    monkeypatch.setenv("ROS_HOSTNAME", "arm.local")
    with pytest.raises(MissingROSError):
        load_ros(1)
    assert os.environ["ROS_IP"] == ""


def test_without_mesh_files_the_description_is_unchanged_and_a_message_says_so():
    text = ulna.load("panda").to_urdf().replace("package://", "package://not_here_")
    messages = []
    assert robot_description(ulna.load(text), messages.append) == with_fingers(text)
    assert "pip install example-robot-data" in messages[0]
    assert "not_here_" in messages[0]


def test_hw2_has_a_copy_of_the_settings_of_rviz_and_no_link():
    """Windows writes a link of git as a text file."""
    copy, original = ROOT / "hw2" / "hw2.rviz", ROOT / "src" / "ulna" / "demo" / "ros" / "demo.rviz"
    assert not any(path.is_symlink() for path in (ROOT / "hw2").rglob("*"))
    assert copy.read_text() == original.read_text()


@pytest.mark.process
def test_hw2_zip_holds_the_assignment_and_a_wheel_of_ulna(tmp_path):
    made = subprocess.run(["make", "hw2-zip", f"PYTHON={sys.executable}"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    with zipfile.ZipFile(ROOT / "hw2.zip") as packed:
        names = {Path(name).name for name in packed.namelist()}
        packed.extractall(tmp_path)
    ours = {path.name for path in (ROOT / "hw2").iterdir() if path.suffix not in (".pyc", "") and path.is_file()}
    assert ours <= names
    assert (tmp_path / "hw2" / "hw2.rviz").read_text() == (ROOT / "src" / "ulna" / "demo" / "ros" / "demo.rviz").read_text()
    (wheel,) = (tmp_path / "hw2").glob("ulna-*.whl")
    with zipfile.ZipFile(wheel) as packed:
        assert {"ulna/demo/ros/ros1.py", "ulna/demo/ros/demo.rviz", "ulna/description/names/panda.urdf"} <= set(packed.namelist())


def test_collision_boxes_draws_the_boxes_of_the_assignment(panda):
    drawn = runpy.run_path(str(ROOT / "hw2" / "collision_boxes.py"))["drawn_by_hand"](panda)
    assert [solid.name for solid in drawn] == [f"box {k}" for k in range(1, 13)]
    standing = {solid.name: solid for solid in standing_boxes(panda, np.zeros(7))}
    np.testing.assert_allclose(standing["box 1"].pose, drawn[0].pose, atol=1e-12)  # the tables agree where nothing moved
    assert standing["box 1"].shape == drawn[0].shape
    far = [np.linalg.norm(standing[s.name].pose[:3, 3] - s.pose[:3, 3]) for s in drawn]
    assert max(far) < 0.2
