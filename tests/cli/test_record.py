import sys

import pytest

from ulna.cli import record as record_file


def test_a_picture_of_any_robot(run, tmp_path, slider):
    result = run("record", tmp_path / "slider.png", "--robot", slider, "--q", "2.5", "--size", "64X48")
    assert result.exit_code == 0
    assert result.stderr == ""
    assert result.stdout.startswith(f"{tmp_path}/slider.png: a picture of 64x48, 0.0")
    assert (tmp_path / "slider.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["panda.avi"], "OUT: 'panda.avi' ends in none of .mp4, .gif, .png"),
        (["panda.mp4", "--size", "big"], "--size: 'big'; width and height are expected, as in 1280x720"),
        (["panda.mp4", "--seconds", "0"], "--seconds: 0; a length above 0 s with at most 20000 pictures is expected"),
        (["panda.mp4", "--fps", "0"], "--fps: 0; 1 to 120 pictures a second are expected"),
        (["panda.mp4", "--size", "8x8"], "--size: 8x8; each side has 16 to 4096 pixels"),
        (["panda.png", "--fps", "10"], "--seconds, --fps: go with a video"),
        (["panda.png", "--seconds", "3"], "--seconds, --fps: go with a video"),
        (["panda.mp4", "--degrees"], "--degrees: goes with --q"),
        (["panda.png", "--at", "1"], "--at: goes with the demo; a robot that stands still has no moments"),
        (["panda.png", "--q", "1"], "--q: 1 number, but 7 are expected"),
        (["missing/panda.png"], "missing/panda.png: cannot be written: No such file or directory"),
    ],
)
def test_a_wrong_argument_is_refused_in_one_line(refusal, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert refusal("record", *arguments, "--robot", "panda").startswith(message)
    assert not list(tmp_path.iterdir())


def test_without_a_robot_and_without_the_demo_it_says_to_name_a_robot(refusal, tmp_path, monkeypatch):
    monkeypatch.setattr(record_file, "load_plugins", lambda _group: [])
    assert refusal("record", tmp_path / "out.mp4").startswith("--robot: name a robot to record")


@pytest.mark.parametrize("package", ["av", "PIL", "trimesh"])
def test_without_the_extra_it_says_how_to_get_it(refusal, monkeypatch, tmp_path, package):
    for name in [name for name in sys.modules if name.startswith("ulna.viewer") or name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    missing = "recording needs the viewer extra: pip install 'ulna[viewer]'"
    assert refusal("record", tmp_path / "panda.mp4", "--robot", "panda") == missing
