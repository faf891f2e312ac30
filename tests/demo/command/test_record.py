"""``ulna record`` without a robot: the demo."""

import pytest


@pytest.mark.slow
def test_record_prints_the_file_and_its_size(run, tmp_path):
    result = run("record", tmp_path / "demo.mp4", "--seconds", "0.5", "--size", "64x48", "--fps", "10")
    assert result.exit_code == 0
    assert result.stderr == ""
    assert result.stdout.startswith(f"{tmp_path}/demo.mp4: 5 pictures, 0.5 s, of 64x48, 0.0")


def test_a_png_of_a_long_demo_is_one_picture(run, tmp_path):
    result = run("record", tmp_path / "demo.png", "--seconds", "900", "--size", "64x48")
    assert result.exit_code == 0
    assert "a picture of 64x48" in result.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["demo.png", "--seconds", "0"], "--seconds: 0; a length above 0 s"),
        (["demo.png", "--seconds", "inf"], "--seconds: inf; a length above 0 s"),
        (["demo.png", "--at", "31"], "--at: 31 s is not between 0 and 30 s"),
        (["demo.mp4", "--at", "3"], "--at: is for a single picture, a .png; demo.mp4 shows the whole demo"),
        (
            ["demo.png", "--package-dir", "x"],
            "--base, --tip, --srdf, --no-srdf, --xacro-arg, --package-dir: require --robot",
        ),
        (["missing/demo.png"], "missing/demo.png: cannot be written: no such folder"),
    ],
)
def test_a_wrong_argument_is_refused_in_one_line(refusal, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert refusal("record", *arguments).startswith(message)
    assert not list(tmp_path.iterdir())
