"""The layouts in which people keep a URDF with its meshes: each loads by its path, or the error says which argument is missing.

docs/reading.md has the same table.
"""

import re
from pathlib import Path

import pytest

import ulna
from ulna import FileError

STL = """solid part
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.1 0
endloop
endfacet
facet normal 0 1 0
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0 0.1
endloop
endfacet
endsolid
"""
URDF = '<robot name="arm"><link name="hand"><collision><geometry><mesh filename="{}"/></geometry></collision></link></robot>'
PACKAGE = "<package><name>arm_description</name></package>"

# The files with their content, by their paths below a folder; the first is the URDF, whose content is the address of the mesh.
LOADS = {
    "meshes beside the URDF": {"arm.urdf": "link.stl", "link.stl": STL},
    "a folder of meshes beside the URDF": {"arm.urdf": "meshes/link.stl", "meshes/link.stl": STL},
    "two folders, as without ROS": {"arm/urdf/arm.urdf": "../meshes/link.stl", "arm/meshes/link.stl": STL},
    "two folders, a level deeper": {"arm/robots/left/arm.urdf": "../../meshes/left/l.stl", "arm/meshes/left/l.stl": STL},
    "two folders, from their common one": {"arm/urdf/arm.urdf": "meshes/link.stl", "arm/meshes/link.stl": STL},
    "a package of ROS": {
        "arm_description/urdf/arm.urdf": "package://arm_description/meshes/link.stl",
        "arm_description/meshes/link.stl": STL,
        "arm_description/package.xml": PACKAGE,
    },
    "a package downloaded under another name": {
        "arm-main/urdf/arm.urdf": "package://arm_description/meshes/link.stl",
        "arm-main/meshes/link.stl": STL,
        "arm-main/package.xml": PACKAGE,
    },
    "a package without package.xml, under another name": {
        "arm-main/urdf/arm.urdf": "package://arm_description/meshes/link.stl",
        "arm-main/meshes/link.stl": STL,
    },
    "a package without package.xml": {
        "arm_description/urdf/arm.urdf": "package://arm_description/meshes/link.stl",
        "arm_description/meshes/link.stl": STL,
    },
    "two packages of a workspace": {
        "src/arm_bringup/urdf/arm.urdf": "package://arm_description/meshes/link.stl",
        "src/arm_bringup/package.xml": "<package><name>arm_bringup</name></package>",
        "src/arm_description/meshes/link.stl": STL,
        "src/arm_description/package.xml": PACKAGE,
    },
    "a folder for a package": {"arm/arm.urdf": "package://meshes/link.stl", "arm/meshes/link.stl": STL},
    "a repository with parts elsewhere in it": {
        "repo/robots/arm/arm.urdf": "../../parts/link.stl",
        "repo/parts/link.stl": STL,
        "repo/.git/HEAD": "ref: refs/heads/main",
    },
    "a model of Gazebo": {
        "models/arm/arm.urdf": "model://arm/meshes/link.stl",
        "models/arm/meshes/link.stl": STL,
        "models/arm/model.config": "<model/>",
    },
    "an expression left by xacro": {
        "arm_description/urdf/arm.urdf": "file://$(find arm_description)/meshes/link.stl",
        "arm_description/meshes/link.stl": STL,
        "arm_description/package.xml": PACKAGE,
    },
    "backslashes, as Windows writes them": {"arm/urdf/arm.urdf": r"..\meshes\link.stl", "arm/meshes/link.stl": STL},
    "backslashes of a package": {
        "arm_description/urdf/arm.urdf": r"package://arm_description\meshes\link.stl",
        "arm_description/meshes/link.stl": STL,
        "arm_description/package.xml": PACKAGE,
    },
    "an absolute path within": {"arm/arm.urdf": "{here}/arm/meshes/link.stl", "arm/meshes/link.stl": STL},
    "an address of a file within": {"arm/urdf/arm.urdf": "file://{here}/arm/meshes/link.stl", "arm/meshes/link.stl": STL},
    "an address with one slash": {"arm/urdf/arm.urdf": "file:{here}/arm/meshes/link.stl", "arm/meshes/link.stl": STL},
    "an address with a host": {"arm/urdf/arm.urdf": "file://localhost{here}/arm/meshes/link.stl", "arm/meshes/link.stl": STL},
    "an address without slashes": {"arm/urdf/arm.urdf": "file:../meshes/link.stl", "arm/meshes/link.stl": STL},
}
# The same, and the argument that the error names, to which the value is in it.
ONE_ARGUMENT = {
    "meshes of elsewhere by an absolute path": {"arm/arm.urdf": "{here}/parts/link.stl", "parts/link.stl": STL},
    "meshes of elsewhere by an address": {"arm/arm.urdf": "file://{here}/parts/link.stl", "parts/link.stl": STL},
    "meshes above without a usual name": {"arm/urdf/arm.urdf": "../parts/link.stl", "arm/parts/link.stl": STL},
    "meshes of another package by dots": {
        "src/arm/urdf/arm.urdf": "../../arm_parts/link.stl",
        "src/arm/package.xml": "<package><name>arm</name></package>",
        "src/arm_parts/link.stl": STL,
    },
    "a package above that is only a folder": {
        "src/arm/urdf/arm.urdf": "package://arm_parts/link.stl",
        "src/arm/package.xml": "<package><name>arm</name></package>",
        "src/arm_parts/link.stl": STL,
    },
}


@pytest.fixture
def put(tmp_path, monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)

    def put(contents: dict[str, str]) -> Path:
        for k, (name, content) in enumerate(contents.items()):
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(URDF.format(content.format(here=tmp_path)) if k == 0 else content)
        return tmp_path / next(iter(contents))

    return put


@pytest.mark.parametrize("layout", LOADS)
def test_a_layout_loads_by_the_path_of_its_urdf(put, layout):
    robot = ulna.load(put(LOADS[layout]), meshes="hulls")
    assert robot.collision_names == ("hand_collision",)
    assert not robot.in_collision([])


@pytest.mark.parametrize("layout", sorted(set(LOADS) - {"two packages of a workspace"}))
def test_its_addresses_are_written_absolute_and_read_again_from_the_same_tree(put, layout):
    file = put(LOADS[layout])
    written = file.with_name("written.urdf")
    written.write_text(ulna.load(file).to_urdf(mesh_paths="file"))
    assert ulna.load(written, meshes="hulls").collision_names == ("hand_collision",)


@pytest.mark.parametrize("layout", ONE_ARGUMENT)
def test_another_layout_is_refused_with_the_argument_that_reads_it(put, layout):
    file = put(ONE_ARGUMENT[layout])
    with pytest.raises(FileError, match="package_dirs=") as caught:
        ulna.load(file, meshes="hulls")
    (folder,) = re.findall(r"package_dirs=\['([^']*)'\]", str(caught.value))
    assert ulna.load(file, meshes="hulls", package_dirs=[folder]).collision_names == ("hand_collision",)


def test_what_is_written_into_another_folder_is_refused_with_the_argument_that_reads_it(put, tmp_path):
    text = ulna.load(put(LOADS["a package of ROS"])).to_urdf(mesh_paths="file")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "arm.urdf").write_text(text)
    with pytest.raises(FileError, match=r"to allow it: package_dirs=") as caught:
        ulna.load(tmp_path / "out" / "arm.urdf", meshes="hulls")
    (folder,) = re.findall(r"package_dirs=\['([^']*)'\]", str(caught.value))
    assert ulna.load(tmp_path / "out" / "arm.urdf", meshes="hulls", package_dirs=[folder]).collision_names


def test_a_text_has_no_folder_and_takes_that_of_its_meshes(put):
    folder = put(LOADS["a folder of meshes beside the URDF"]).parent
    text = URDF.format("meshes/link.stl")
    with pytest.raises(FileError, match=r"text has no folder: give package_dirs=\[FOLDER\], where FOLDER/meshes/link.stl is"):
        ulna.load(text, meshes="hulls")
    assert ulna.load(text, meshes="hulls", package_dirs=[folder]).collision_names


def test_a_missing_package_is_named_with_the_argument(put):
    with pytest.raises(FileError, match=r"package_dirs=\[\.\.\.\] names the folder that contains the package 'arm_parts'"):
        ulna.load(put({"arm.urdf": "package://arm_parts/link.stl"}), meshes="hulls")


@pytest.mark.parametrize("name", ["meshes/Link.stl", "Meshes/link.stl", "meshes/link.STL"])
def test_a_name_that_differs_by_case_only_is_said(put, name):
    with pytest.raises(FileError, match=r"Only upper and lower case differ from .*meshes/link\.stl: rename one of them"):
        ulna.load(put({"arm.urdf": name, "meshes/link.stl": STL}), meshes="hulls")


@pytest.mark.parametrize("scheme", ["http", "https"])
def test_nothing_is_downloaded(put, scheme):
    with pytest.raises(FileError, match="nothing is downloaded: save it beside the description"):
        ulna.load(put({"arm.urdf": f"{scheme}://example.org/link.stl"}), meshes="hulls")


def test_a_home_folder_with_meshes_in_it_is_nobodys_tree(put, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    file = put({"Downloads/arm.urdf": "../meshes/link.stl", "meshes/link.stl": STL, ".git/HEAD": ""})
    with pytest.raises(FileError, match="lies outside"):
        ulna.load(file, meshes="hulls")


def test_a_link_out_of_the_tree_is_not_followed(put, tmp_path):
    file = put({"arm/urdf/arm.urdf": "../meshes/linked.stl", "arm/meshes/link.stl": STL, "secret/key.stl": STL})
    (tmp_path / "arm/meshes/linked.stl").symlink_to(tmp_path / "secret/key.stl")
    with pytest.raises(FileError, match="lies outside"):
        ulna.load(file, meshes="hulls")


def test_the_package_of_a_maker_is_loaded_and_plans_without_ros(put):
    """The layout of a maker's repository: a xacro file in urdf/, a macro that it includes, limits in YAML, meshes."""
    xacro = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    file = put(
        {
            "maker_robots-ros2/maker_m6_support/urdf/unused.urdf": "x.stl",
            "maker_robots-ros2/maker_m6_support/package.xml": "<package><name>maker_m6_support</name></package>",
            "maker_robots-ros2/maker_m6_support/meshes/collision/link.stl": STL,
            "maker_robots-ros2/maker_m6_support/config/limits.yaml": "shoulder: {lower: -90, upper: 90}",
            "maker_robots-ros2/maker_m6_support/urdf/m6.xacro": f"""<robot name="m6" {xacro}>
  <xacro:arg name="prefix" default=""/>
  <xacro:include filename="$(find maker_m6_support)/urdf/m6_macro.xacro"/>
  <xacro:m6 prefix="$(arg prefix)"/>
</robot>""",
            "maker_robots-ros2/maker_m6_support/urdf/m6_macro.xacro": f"""<robot {xacro}>
  <xacro:macro name="m6" params="prefix">
    <xacro:property name="limits" value="${{xacro.load_yaml('$(find maker_m6_support)/config/limits.yaml')}}"/>
    <link name="${{prefix}}base"/>
    <link name="${{prefix}}arm"><collision><geometry>
      <mesh filename="package://maker_m6_support/meshes/collision/link.stl"/></geometry></collision></link>
    <joint name="${{prefix}}shoulder" type="revolute"><parent link="${{prefix}}base"/><child link="${{prefix}}arm"/>
      <axis xyz="0 0 1"/><limit lower="${{radians(limits['shoulder']['lower'])}}"
      upper="${{radians(limits['shoulder']['upper'])}}" velocity="1" effort="1"/></joint>
  </xacro:macro>
</robot>""",
        }
    ).with_name("m6.xacro")
    robot = ulna.load(file, xacro_args={"prefix": "left_"}, meshes="hulls")
    assert robot.joint_names == ("left_shoulder",)
    assert robot.upper[0] == pytest.approx(1.5707963)
    assert robot.plan([-1.0], [1.0])
