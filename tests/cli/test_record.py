import sys

import pytest


def test_it_says_what_it_has_made(run, tmp_path):
    result = run("record", tmp_path / "demo.mp4", "--seconds", "0.5", "--size", "64x48", "--fps", "10")
    assert result.exit_code == 0
    assert result.stderr == ""
    assert result.stdout.startswith(f"{tmp_path}/demo.mp4: 5 pictures, 0.5 s, of 64x48, 0.0")


def test_a_picture_of_any_robot(run, tmp_path, slider):
    result = run("record", tmp_path / "slider.png", "--robot", slider, "--q", "2.5", "--size", "64X48")
    assert result.exit_code == 0
    assert "a picture of 64x48" in result.stdout
    assert (tmp_path / "slider.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_of_a_long_story_is_one_picture(run, tmp_path):
    result = run("record", tmp_path / "demo.png", "--seconds", "900", "--size", "64x48")
    assert result.exit_code == 0
    assert "a picture of 64x48" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["demo.avi"], "OUT: 'demo.avi' ends in none of .mp4, .gif, .png"),
        (["demo.mp4", "--size", "big"], "--size: 'big'; width and height are expected, as in 1280x720"),
        (["demo.mp4", "--seconds", "0"], "--seconds: 0; more than 0 s and at most 20000 pictures can be had"),
        (["demo.mp4", "--fps", "0"], "--fps: 0; 1 to 120 pictures a second can be had"),
        (["demo.mp4", "--size", "8x8"], "--size: 8x8; each side has 16 to 4096 pixels"),
        (["demo.png", "--seconds", "0"], "--seconds: 0; more than 0 s"),
        (["demo.png", "--seconds", "inf"], "--seconds: inf; more than 0 s"),
        (["demo.png", "--fps", "10"], "--seconds, --fps: go with a video"),
        (["demo.png", "--robot", "panda", "--seconds", "3"], "--seconds, --fps: go with a video"),
        (["demo.mp4", "--degrees"], "--degrees: goes with --q"),
        (["demo.png", "--at", "31"], "--at: 31 s is not between 0 and 30 s"),
        (["demo.mp4", "--at", "3"], "--at: is for a single picture, a .png; demo.mp4 shows the whole story"),
        (["demo.png", "--at", "1", "--robot", "panda"], "--at: goes with the demo; a robot that stands has no moments"),
        (["demo.png", "--package-dir", "x"], "--xacro-arg, --package-dir: go with --robot; without it the demo is recorded"),
        (["demo.png", "--robot", "panda", "--q", "1"], "--q: 1 number, but 7 are expected"),
        (["missing/demo.png"], "missing/demo.png: cannot be written: No such file or directory"),
    ],
)
def test_a_wrong_question_is_answered_in_one_line(refusal, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert refusal("record", *arguments).startswith(message)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("package", ["av", "PIL", "trimesh"])
def test_without_the_extra_it_says_how_to_get_it(refusal, monkeypatch, tmp_path, package):
    for name in [name for name in sys.modules if name.startswith("ulna.viewer") or name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    assert refusal("record", tmp_path / "demo.mp4") == "recording needs the viewer extra: pip install 'ulna[viewer]'"
