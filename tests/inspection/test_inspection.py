"""``ulna.inspect``: a sound document has no findings, and one defect has the one finding that names it."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import ulna
from inspection_cases import DEFECTS, LIGHT, SOUND
from mesh_texts import stl
from robot_files import EXAMPLES
from ulna import InputError, MissingExtraError, Severity, UlnaError
from ulna.errors import install_command

LARGE = stl([(0, 0, 0), (120, 0, 0), (0, 30, 0), (0, 0, 60)])


def told(inspection):
    return [(finding.severity, finding.where, finding.message) for finding in inspection.findings]


def test_a_sound_document_has_no_findings():
    inspection = ulna.inspect(SOUND)
    assert told(inspection) == []
    assert inspection.worst is None
    assert (inspection.loads, inspection.n_dof, inspection.name) == (True, 2, "arm")
    assert inspection.joint_types == {"revolute": 1, "prismatic": 2}
    assert inspection.reach == pytest.approx(0.3 + 0.5 + 0.4)


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_has_its_finding_and_no_other(name):
    written, instead, expected = DEFECTS[name]
    assert written in SOUND
    inspection = ulna.inspect(SOUND.replace(written, instead))
    found = told(inspection)
    assert [finding[:2] for finding in found] == [finding[:2] for finding in expected]
    for (_, _, message), (_, _, beginning) in zip(found, expected, strict=True):
        assert re.match(beginning.replace("?", r"\?"), message), message
    assert inspection.loads == all(severity != Severity.ERROR for severity, _, _ in expected)


def test_findings_carry_their_line():
    written, instead, _ = DEFECTS["an attribute misspelt"]
    [finding] = ulna.inspect(SOUND.replace(written, instead)).findings
    assert SOUND.splitlines()[finding.line - 1].strip().startswith("<limit")


@pytest.mark.parametrize("text", ["<robot", "<sdf/>", '<!DOCTYPE r [<!ENTITY a "b">]><robot>&a;</robot>', '<robot name="r"/>'])
def test_what_is_no_robot_at_all_has_the_error_of_load(text):
    with pytest.raises(UlnaError) as refused:
        ulna.load(text)
    [finding] = ulna.inspect(text).findings
    assert finding.severity == Severity.ERROR
    assert str(refused.value).endswith(finding.message)


def test_a_file_that_is_not_there_and_wrong_arguments_are_refused_as_by_load():
    with pytest.raises(ulna.FileError, match=r"nowhere.urdf: no such file"):
        ulna.inspect("nowhere.urdf")
    with pytest.raises(InputError, match=r"^package_dirs: "):
        ulna.inspect("panda", package_dirs="packages")
    with pytest.raises(InputError, match=r"^source: "):
        ulna.inspect(5)


def test_missing_meshes_of_one_package_are_one_finding_with_every_path_that_was_tried(tmp_path):
    text = re.sub("<(sphere|cylinder|box) [^>]*/>", '<mesh filename="package://parts/x.stl"/>', SOUND)
    path = tmp_path / "arm.urdf"
    path.write_text(text.replace("x.stl", "y.stl", 1))
    [finding] = ulna.inspect(path, package_dirs=iter([tmp_path / "packages"])).findings
    assert finding.message == "2 meshes of package 'parts' not found: y.stl, x.stl"
    assert str(tmp_path / "packages" / "parts" / "y.stl") in finding.tried
    assert str(tmp_path / "parts" / "y.stl") in finding.tried
    (tmp_path / "parts").mkdir()
    for name in ("x.stl", "y.stl"):
        (tmp_path / "parts" / name).write_text(LARGE)
    messages = [finding.message for finding in ulna.inspect(path).findings]
    assert messages == [f"mesh {name}.stl is 120 x 30 x 60 m: millimeters? Lengths are meters" for name in "yx"]
    path.write_text(path.read_text().replace('.stl"', '.stl" scale="1e-3 1e-3 -1e-3"'))
    assert ulna.inspect(path).findings == ()


@pytest.mark.parametrize(
    ("content", "reason"), [("solid s", "it has no triangles"), (stl([(0, 0, "nan")] * 4), "points that are not finite")]
)
def test_a_mesh_that_cannot_be_read_is_a_warning(tmp_path, content, reason):
    path = tmp_path / "arm.urdf"
    path.write_text(SOUND.replace('<sphere radius="0.1"/>', '<mesh filename="ball.STL"/>'))
    (tmp_path / "ball.STL").write_text(content)
    [finding] = ulna.inspect(path).findings
    assert (finding.severity, finding.where) == (Severity.WARNING, "link 'base'")
    assert reason in finding.message


def test_without_what_reads_meshes_they_are_counted_and_the_extra_is_named(tmp_path, monkeypatch):
    def lacking():
        raise MissingExtraError("reading meshes", "hulls")

    monkeypatch.setattr("ulna.inspection.links.mesh_reader", lacking)
    path = tmp_path / "arm.urdf"
    path.write_text(SOUND.replace('<sphere radius="0.1"/>', '<mesh filename="ball.stl"/>'))
    (tmp_path / "ball.stl").write_text(LARGE)
    [finding] = ulna.inspect(path).findings
    message = f"1 mesh was found, but not read: reading meshes needs the hulls extra: {install_command('hulls')}"
    assert (finding.severity, finding.message) == (Severity.NOTE, message)


def test_the_grippers_of_the_pr2_are_reported_as_contradicting_themselves():
    inspection = ulna.inspect(EXAMPLES / "pr2_description/urdf/pr2.urdf")
    contradictions = [finding.where for finding in inspection.findings if "no range" in finding.message]
    assert contradictions == ["joint 'r_gripper_r_parallel_root_joint'", "joint 'l_gripper_r_parallel_root_joint'"]


def test_a_follower_that_contradicts_another_follower_is_reported_and_its_limits_do_not_hold():
    third = f"""<link name="third">{LIGHT}</link>
    <joint name="grip three" type="prismatic"><parent link="upper"/><child link="third"/>
    <axis xyz="1 0 0"/><limit lower="0.3" upper="0.4" velocity="2" effort="3"/><mimic joint="grip"/></joint></robot>"""
    text = SOUND.replace('lower="0" upper="0.4"', 'lower="0" upper="0.1"').replace("</robot>", third)
    narrowing, finding = ulna.inspect(text).findings
    assert (narrowing.where, narrowing.message) == (
        "joint 'grip too'",
        "its limits narrow 'grip', which it mimics, to 0.1 to 0.2",
    )
    assert (finding.where, finding.severity) == ("joint 'grip three'", Severity.WARNING)
    assert ulna.load(text).upper[1] == 0.2


def test_a_xacro_file_is_inspected_expanded_and_one_that_does_not_expand_has_its_error(tmp_path):
    path = tmp_path / "arm.xacro"
    declared = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    path.write_text(SOUND.replace('<robot name="arm">', declared).replace('"-1"', '"${1 + 1}"'))
    inspection = ulna.inspect(path)
    assert "lower limit 2.0 is above upper limit 1.0" in inspection.findings[0].message
    assert len(inspection.tree) == 4
    path.write_text(path.read_text().replace("1 + 1", "1 +"))
    assert ulna.inspect(path).tree == ()


def test_the_tree_is_drawn_depth_first_and_a_loop_does_not_hold_it_up():
    rows = [(row.depth, row.link, row.joint) for row in ulna.inspect(SOUND).tree]
    assert rows == [(0, "base", None), (1, "upper", "shoulder"), (2, "left", "grip"), (2, "right", "grip too")]
    loop = SOUND.replace('<child link="left"/>', '<child link="base"/>')
    assert {row.link for row in ulna.inspect(loop).tree} == {"base", "upper", "left", "right"}


@pytest.mark.filterwarnings("ignore::ulna.DescriptionWarning")
@given(
    st.lists(
        st.tuples(st.integers(0, len(SOUND) - 1), st.integers(0, 12), st.sampled_from(["", "x", "-", "9", "<", '"', "/>"])),
        max_size=4,
    )
)
def test_whatever_a_document_has_become_it_is_inspected_and_loads_if_load_takes_it(edits):
    text = SOUND
    for start, length, instead in edits:
        text = text[:start] + instead + text[start + length :]
    if not text.lstrip().startswith("<"):
        return
    inspection = ulna.inspect(text)
    try:
        ulna.load(text)
    except UlnaError:
        assert inspection.worst == Severity.ERROR
        assert not inspection.loads
    else:
        assert inspection.loads


@pytest.mark.parametrize("by", ["file://{}/secret/key.stl", "../secret/key.stl", "linked.stl"])
def test_a_mesh_outside_is_named_and_not_read(tmp_path, by):
    secret, path = tmp_path / "secret" / "key.stl", tmp_path / "in" / "arm.urdf"
    for folder in (secret.parent, path.parent):
        folder.mkdir()
    secret.write_text(LARGE)
    (path.parent / "linked.stl").symlink_to(secret)
    path.write_text(re.sub("<(sphere|cylinder|box) [^>]*/>", f'<mesh filename="{by.format(tmp_path)}"/>', SOUND))
    messages = {finding.message for finding in ulna.inspect(path).findings}
    reason = "lies outside the description's folder, its package or repository and package_dirs, so it is not read"
    advice = f"to allow it: package_dirs=['{tmp_path}'] (--package-dir {tmp_path})"
    assert messages == {f"mesh {by.rpartition('/')[2]} cannot be read: {reason}; {advice}"}
    assert any("120 x 30 x 60" in finding.message for finding in ulna.inspect(path, package_dirs=[tmp_path]).findings)
