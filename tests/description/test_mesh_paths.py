"""``to_urdf(mesh_paths="file")``: mesh paths as absolute file URIs, for programs that cannot resolve packages."""

import re
from pathlib import Path

import pytest

import ulna
from ulna import FileError, InputError

URDF = """<robot name="r">
  <!-- a comment, which stays -->
  <link name="a"><visual><geometry><mesh filename="{0}"/></geometry>
    <material name="m"><texture filename="{1}"/></material></visual></link>
</robot>"""


@pytest.fixture
def file(tmp_path):
    for name in ("my hand.stl", "skin.png"):
        (tmp_path / "arm" / "meshes").mkdir(parents=True, exist_ok=True)
        (tmp_path / "arm" / "meshes" / name).write_text("")
    file = tmp_path / "arm" / "arm.urdf"
    file.write_text(URDF.format("package://arm/meshes/my%20hand.stl", "meshes/skin.png"))
    return file


def addresses(text: str) -> list[str]:
    return re.findall(r'filename="([^"]*)"', text)


def test_package_and_relative_paths_become_file_uris_and_the_rest_is_unchanged(file, tmp_path):
    text = ulna.load(file).to_urdf(mesh_paths="file")
    expected = [(tmp_path / "arm" / "meshes" / name).resolve().as_uri() for name in ("my hand.stl", "skin.png")]
    assert addresses(text) == expected
    assert "<!-- a comment, which stays -->" in text
    assert addresses(ulna.load(text).to_urdf(mesh_paths="file")) == expected


def test_mesh_paths_are_unchanged_by_default(file):
    assert ulna.load(file).to_urdf() == ulna.load(file).to_urdf(mesh_paths="given") == file.read_text()


def test_the_package_dirs_of_load_are_used_later(file, tmp_path):
    elsewhere = tmp_path / "elsewhere" / "arm.urdf"
    elsewhere.parent.mkdir()
    elsewhere.write_text(file.read_text().replace("meshes/skin.png", "package://arm/meshes/skin.png"))
    robot = ulna.load(elsewhere, package_dirs=[str(tmp_path)])
    assert all(address.startswith("file://") for address in addresses(robot.to_urdf(mesh_paths="file")))
    assert (
        robot.with_tool([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).to_urdf(mesh_paths="file").count("file://") == 1
    )


def test_the_error_for_a_missing_mesh_lists_every_path_tried(file, tmp_path):
    file.write_text(URDF.format("package://arm/gone.stl", "gone.png"))
    with pytest.raises(
        FileError, match=r"^package://arm/gone\.stl: no such file \(1 more of this robot is missing\); tried "
    ) as caught:
        ulna.load(file, package_dirs=[tmp_path / "given"]).to_urdf(mesh_paths="file")
    for path in (tmp_path / "given" / "arm" / "gone.stl", tmp_path / "arm" / "gone.stl"):
        assert str(path) in str(caught.value)


def test_a_uri_that_leaves_its_package_is_not_followed(file):
    file.write_text(URDF.format("package://arm/../secret.stl", "meshes/skin.png"))
    with pytest.raises(FileError, match=r"tried nothing, because it lies outside its package$"):
        ulna.load(file).to_urdf(mesh_paths="file")


def test_an_unknown_value_of_mesh_paths_is_refused():
    with pytest.raises(InputError, match=r"^mesh_paths: 'fil' is not known; did you mean 'file'\?$"):
        ulna.load("panda").to_urdf(mesh_paths="fil")


def test_the_bundled_panda_finds_its_meshes_in_the_data_package(panda):
    paths = [Path(address.removeprefix("file://")) for address in addresses(panda.to_urdf(mesh_paths="file"))]
    assert len(paths) >= 8
    assert all(path.is_file() for path in paths)
