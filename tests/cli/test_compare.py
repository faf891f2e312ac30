"""``ulna compare``."""

import pytest


@pytest.fixture
def longer(slider, tmp_path):
    path = tmp_path / "longer.urdf"
    path.write_text(slider.read_text().replace('upper="10"', 'upper="11"').replace("1 1 1", "1 1 2"))
    return path


def test_the_same_robot_is_exit_status_0(run, ask, slider):
    shown = run("compare", slider, slider)
    assert shown.exit_code == 0
    assert shown.stdout.endswith("the same\n")
    answer = ask("compare", slider, slider)
    assert (answer.exit_code, answer.same, answer.differences) == (0, True, [])


def test_differences_are_exit_status_1_and_are_listed(run, ask, slider, longer):
    answer = ask("compare", slider, longer)
    assert (answer.exit_code, answer.same) == (1, False)
    assert answer.differences == [
        {"kind": "limits", "where": "slide upper", "a": "10", "b": "11"},
        {"kind": "collision", "where": "cube", "a": "box, extents 1, 1, 1", "b": "box, extents 1, 1, 2"},
    ]
    shown = run("compare", slider, longer)
    assert shown.exit_code == 1
    assert shown.stdout.endswith("2 differences\n")


def test_ignored_kinds_and_values_within_tolerance_are_not_differences(run, slider, longer):
    assert run("compare", slider, longer, "--ignore", "limits", "--ignore", "collision").exit_code == 0
    assert run("compare", slider, longer, "--ignore", "collision", "--limit", "2").exit_code == 0


def test_bad_arguments_are_exit_status_2(refusal, slider):
    assert refusal("compare", slider, "nowhere.urdf") == "nowhere.urdf: no such file"
    assert "did you mean 'pose'" in refusal("compare", slider, slider, "--ignore", "poses")


def test_long_mesh_paths_are_wrapped_to_80_columns(run, slider, tmp_path):
    texts = [
        slider.read_text().replace('<box size="1 1 1"/>', f'<mesh filename="package://{k}{"far/" * 40}x.stl"/>') for k in "ab"
    ]
    for k, text in zip("ab", texts, strict=True):
        (tmp_path / f"{k}.urdf").write_text(text)
    shown = run("compare", tmp_path / "a.urdf", tmp_path / "b.urdf").stdout
    assert max(map(len, shown.splitlines())) <= 80
    assert "…" not in shown
