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


URDF = """<robot name="m"><link name="a"/><link name="b"><collision><origin xyz="0 0 0.1"/><geometry><box size="1 2 3"/>
</geometry></collision></link><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="2" effort="5" velocity="3"/></joint></robot>"""
SDF = """<sdf version="1.9"><model name="m"><link name="a"/><link name="b"><pose relative_to="j"/><collision name="b_collision">
<pose>0 0 0.1 0 0 0</pose><geometry><box><size>1 2 3</size></box></geometry></collision></link>
<joint name="j" type="revolute"><pose relative_to="a">0.1 0.2 0.3 0.1 0.2 0.3</pose><parent>a</parent><child>b</child>
<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper><effort>5</effort><velocity>3</velocity></limit></axis></joint>
</model></sdf>"""


def test_an_sdf_is_compared_with_a_urdf_and_inspected_and_written_as_one(run, tmp_path):
    urdf, sdf, written = (tmp_path / name for name in ("x.urdf", "x.sdf", "written.urdf"))
    urdf.write_text(URDF)
    sdf.write_text(SDF)
    assert run("compare", urdf, sdf).exit_code == 0
    assert "1 dof, 2 links, 1 joint (1 revolute)" in run("inspect", sdf).stdout
    written.write_text(run("urdf", sdf).stdout)
    assert run("compare", written, sdf).exit_code == 0
    sdf.write_text(SDF.replace("<upper>2", "<upper>1"))
    assert run("compare", urdf, sdf).exit_code == 1
