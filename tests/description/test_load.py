"""The sources of a robot: a bundled name, a path, or the URDF text; and sources that are refused."""

from pathlib import Path

import numpy as np
import pytest

import ulna
from ulna import DescriptionWarning, FileError, InputError, UlnaError

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="hand"/>
  <joint name="wrist" type="continuous"><parent link="base"/><child link="hand"/></joint>
</robot>
"""
XACRO = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="$(find parts)/part.xacro"/></robot>'


def test_a_path_its_string_and_the_text_give_the_same_robot(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    robots = [ulna.load(source) for source in (file, str(file), ARM, "\n  " + ARM, "\ufeff" + ARM)]
    for robot in robots:
        assert (robot.name, robot.link_names, robot.joint_names) == ("arm", ("base", "hand"), ("wrist",))
        assert np.array_equal(robot.link_poses([0.3]), robots[0].link_poses([0.3]))


def test_text_with_an_xml_declaration_can_begin_with_a_blank_line():
    assert ulna.load('\n<?xml version="1.0"?>\n' + ARM).name == "arm"


def test_to_urdf_returns_the_text_that_was_loaded(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    assert ulna.load(tmp_path / "arm.urdf").to_urdf() == ARM
    assert ulna.load(ARM).to_urdf() == ARM


def test_a_bundled_name_comes_before_a_file_of_the_same_name(tmp_path, monkeypatch):
    (tmp_path / "panda").write_text(ARM)
    monkeypatch.chdir(tmp_path)
    assert ulna.load("panda").n_dof == 7
    assert ulna.load(Path("panda")).name == "arm"


@pytest.mark.parametrize("source", [None, 3, b"<robot/>", ["panda"], object()], ids=lambda s: type(s).__name__)
def test_a_source_of_the_wrong_type_is_refused_with_its_type(source):
    with pytest.raises(InputError, match=f"source: {type(source).__name__}; a name, a path or URDF text is expected"):
        ulna.load(source)


def test_a_folder_is_not_a_description(tmp_path):
    with pytest.raises(FileError, match="Is a directory") as caught:
        ulna.load(tmp_path)
    assert caught.value.path == str(tmp_path)
    assert isinstance(caught.value, OSError)


@pytest.mark.parametrize("source", ["", "  \n"], ids=["empty", "blank"])
def test_an_empty_string_is_refused_as_empty(source):
    with pytest.raises(UlnaError, match="empty"):
        ulna.load(source)


def test_a_missing_file_is_named_and_a_mistyped_robot_is_suggested():
    with pytest.raises(FileError, match=r"^no/such\.urdf: no such file$"):
        ulna.load("no/such.urdf")
    with pytest.raises(FileError, match=r"^pandas: no such file; and not a robot's name; did you mean 'panda' \(bundled\)"):
        ulna.load("pandas")


@pytest.mark.parametrize(
    "source", ["a\0b.urdf", "a" * 5000, "\u8282" * 90, "\udcff.urdf", '<robot name="\udcff"/>'], ids=lambda s: ascii(s[:20])
)
def test_unreadable_text_is_refused_with_an_ulna_error(source):
    with pytest.raises(UlnaError):
        ulna.load(source)


@pytest.mark.parametrize("source", [ARM, "panda"], ids=["a plain URDF", "a bundled robot"])
def test_xacro_arguments_for_what_is_not_xacro_change_nothing_and_are_warned_of(source):
    with pytest.warns(DescriptionWarning, match=r"is not a xacro file, so it takes no arguments: 'hand' of xacro_args"):
        assert ulna.load(source, xacro_args={"hand": "true"}).link_names == ulna.load(source).link_names


def test_xacro_arguments_that_are_not_a_mapping_are_refused():
    with pytest.raises(InputError, match="xacro_args"):
        ulna.load(XACRO, xacro_args="hand:=true")


@pytest.mark.parametrize("package_dirs", ["/srv/robots", 3], ids=["one bare string", "a number"])
def test_package_dirs_that_are_not_a_list_are_refused(package_dirs):
    with pytest.raises(InputError, match="package_dirs"):
        ulna.load(XACRO, package_dirs=package_dirs)


def test_the_description_has_its_source_and_line_numbers(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    assert ulna.load(tmp_path / "arm.urdf").description.source == "arm.urdf"
    assert ulna.load(ARM).description.source == "URDF text"
    assert [link.line for link in ulna.load(ARM).description.links] == [2, 3]


def test_a_file_whose_name_differs_in_case_only_is_named(tmp_path, monkeypatch):
    (tmp_path / "Arms").mkdir()
    (tmp_path / "Arms" / "Reach.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    (tmp_path / "Points.CSV").write_text("1,2,3\n")
    (tmp_path / "Cell.json").write_text("{}")
    (tmp_path / "limits.YAML").write_text("")
    monkeypatch.chdir(tmp_path)
    robot = ulna.load("panda")
    for call, twin in (
        (lambda: ulna.load("Arms/reach.URDF"), "Arms/Reach.urdf"),
        (lambda: ulna.load(tmp_path / "arms" / "Reach.urdf"), tmp_path / "Arms" / "Reach.urdf"),
        (lambda: ulna.inspect("Arms/reach.urdf"), "Arms/Reach.urdf"),
        (lambda: ulna.PointCloud.from_file("points.csv", radius=0.01), "Points.CSV"),
        (lambda: ulna.load_world("cell.json"), "Cell.json"),
        (lambda: robot.plan(robot.home, robot.home).trajectory(limits="limits.yaml"), "limits.YAML"),
    ):
        with pytest.raises(FileError, match=r"no such file; only upper and lower case differ from ") as caught:
            call()
        assert str(caught.value).split("differ from ")[1].startswith(str(twin))
    with pytest.raises(FileError, match=r"no such file$"):
        ulna.load("Arms/other.urdf")
