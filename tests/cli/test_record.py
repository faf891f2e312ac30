import sys

import numpy as np
import pytest
from PIL import Image

import ulna
from ulna.cli import record as record_file
from ulna.cli.rows import read_motion
from ulna.errors import install_command


def test_a_picture_of_any_robot(run, tmp_path, slider):
    result = run("record", tmp_path / "slider.png", "--robot", slider, "--q", "2.5", "--size", "64X48")
    assert result.exit_code == 0
    assert result.stderr == ""
    assert result.stdout.startswith(f"{tmp_path}/slider.png: a picture of 64x48, 0.0")
    assert (tmp_path / "slider.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_from_two_angles_or_a_side(run, refusal, tmp_path, slider):
    for name, camera in (("a.png", ("--camera", "90, 0", "--degrees")), ("b.png", ("--camera", "left")), ("c.png", ())):
        assert run("record", tmp_path / name, "--robot", slider, "--size", "64x48", *camera).exit_code == 0
    a, b, c = (np.asarray(Image.open(tmp_path / name).convert("RGB")).astype(int) for name in ("a.png", "b.png", "c.png"))
    assert np.abs(a - b).mean() < 1.0 < np.abs(a - c).mean()
    assert (
        refusal("record", tmp_path / "d.png", "--camera", "left") == "--camera: requires --robot; in the demo the camera is fixed"
    )


@pytest.mark.slow
def test_a_video_of_a_trajectory_file_and_a_scene_file(run, tmp_path):
    world = ulna.World()
    world.add("crate", ulna.Box((0.1, 0.1, 0.1)), ulna.pose((0.6, 0, 0.3)))
    ulna.save_world(world, tmp_path / "scene.json")
    home = ulna.load("panda").home
    rows = np.array([home, home + 0.2])
    np.save(tmp_path / "rows.npy", rows)
    np.savetxt(tmp_path / "rows.csv", rows, delimiter=",", header="j1,j2,j3,j4,j5,j6,j7", comments="")
    videos = []
    for name in ("rows.npy", "rows.csv"):
        out = tmp_path / f"{name}.mp4"
        options = ("--scene", tmp_path / "scene.json", "--trajectory", tmp_path / name, "--seconds", "0.3", "--size", "64x48")
        result = run("record", out, *options)
        assert (result.exit_code, result.stderr) == (0, "")
        assert "9 pictures, 0.3 s, of 64x48" in result.stdout
        videos.append(out.read_bytes())
    assert videos[0] == videos[1]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", "1,2\n", "--trajectory: a.csv has shape (1, 2); rows of 7 joint positions are expected"),
        ("a.csv", "", "--trajectory: a.csv has no row of numbers"),
        ("a.csv", "0,0,0,0,0,0,0\nx\n", "--trajectory: a.csv:2: 'x' is not a row of numbers"),
        ("a.csv", "0,0,0,0,0,0,0\n1,2\n", "--trajectory: a.csv:2: 2 numbers, but 7 in the row before"),
        ("a.csv", "0,0,0,nan,0,0,0\n", "--trajectory: a.csv: row 0 is not finite"),
        ("a.npy", "1,2", "--trajectory: a.npy: it is not a .npy file of versions 1 to 3"),
    ],
)
def test_a_bad_trajectory_file_is_refused_in_one_line(refusal, tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    assert refusal("record", tmp_path / "a.mp4", "--trajectory", tmp_path / name).startswith(message)
    assert not (tmp_path / "a.mp4").exists()


@pytest.mark.parametrize("two", [("--trajectory", "a.csv", "--q", "0"), ("--trajectory", "a.csv", "--plan", "a.csv")])
def test_only_one_source_of_joint_positions_is_accepted(refusal, tmp_path, two):
    assert refusal("record", tmp_path / "a.mp4", *two).startswith("--q, --trajectory, --plan: give at most one")


@pytest.mark.slow
def test_a_motion_of_ulna_plan_is_recorded_in_its_time(run, tmp_path, panda):
    world = ulna.World()
    world.add("post", ulna.Box((0.1, 0.1, 0.9)), ulna.pose((0.45, 0.2, 0.45)))
    goal = panda.home + 0.9 * np.eye(7)[0]
    motion = panda.plan(panda.home, goal, world).trajectory(acceleration=5.0)
    motion.to_csv(tmp_path / "motion.csv", period=0.01)
    duration, rows = read_motion(tmp_path / "motion.csv", panda)
    assert duration == motion.duration
    even = motion.at(np.linspace(0, duration, len(rows))).q
    assert np.allclose(rows, even, atol=1e-3)  # linear between lines 10 ms apart
    result = run("record", tmp_path / "arm.mp4", "--plan", tmp_path / "motion.csv", "--size", "64x48", "--fps", "10")
    assert (result.exit_code, result.stderr) == (0, "")
    assert f"{round(10 * duration)} pictures" in result.stdout


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("0,0,0,0,0,0,0\n", "--plan: a.csv has shape (1, 7); rows of a time and 7 joint positions"),
        ("0,0,0,0,0,0,0,0\n0,0,0,0,0,0,0,0\n", "--plan: a.csv: row 1 is not later than the row before"),
        ("0,0,0,0,0,0,0,inf\n", "--plan: a.csv: row 0 is not finite"),
    ],
)
def test_a_bad_motion_file_is_refused_in_one_line(refusal, tmp_path, content, message):
    (tmp_path / "a.csv").write_text(content)
    assert refusal("record", tmp_path / "a.mp4", "--plan", tmp_path / "a.csv").startswith(message)
    assert not (tmp_path / "a.mp4").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["panda.avi"], "OUT: 'panda.avi' ends in none of .mp4, .gif, .png"),
        (["panda.mp4", "--size", "big"], "--size: 'big'; width and height are expected, as in 1280x720"),
        (
            ["panda.png", "--camera", "up"],
            "--camera: 'up'; corner, front, back, left, right, top, or two angles [rad] are",
        ),
        (["panda.png", "--camera", "pi/4"], "--camera: 1 number, but 2 are expected: turn, rise"),
        (["panda.mp4", "--seconds", "0"], "--seconds: 0; a length above 0 s with at most 20000 pictures is expected"),
        (["panda.mp4", "--fps", "0"], "--fps: 0; 1 to 120 pictures a second are expected"),
        (["panda.mp4", "--size", "8x8"], "--size: 8x8; each side has 16 to 4096 pixels"),
        (["panda.png", "--fps", "10"], "--seconds, --fps: require a video"),
        (["panda.png", "--seconds", "3"], "--seconds, --fps: require a video"),
        (["panda.png", "--at", "1"], "--at: requires the demo; a robot's picture has no time"),
        (["panda.png", "--q", "1"], "--q: 1 number, but 7 are expected"),
        (["missing/panda.png"], "missing/panda.png: cannot be written: no such folder"),
    ],
)
def test_a_wrong_argument_is_refused_in_one_line(refusal, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert refusal("record", *arguments, "--robot", "panda").startswith(message)
    assert not list(tmp_path.iterdir())


def test_without_a_robot_and_without_the_demo_a_robot_is_required(refusal, tmp_path, monkeypatch):
    monkeypatch.setattr(record_file, "load_plugins", lambda _group: [])
    assert refusal("record", tmp_path / "out.mp4").startswith("--robot: name a robot to record")


@pytest.mark.parametrize("package", ["av", "PIL", "trimesh"])
def test_a_missing_viewer_extra_is_named(refusal, monkeypatch, tmp_path, package):
    for name in [name for name in sys.modules if name.startswith("ulna.viewer") or name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    missing = f"recording needs the viewer extra: {install_command('viewer')}"
    assert refusal("record", tmp_path / "panda.mp4", "--robot", "panda") == missing
