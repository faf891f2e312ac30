"""Resolving ``package://`` and other URIs: the search order of the folders, and paths that leave a package."""

import os
import sys
from pathlib import Path

import pytest

import ulna
from ulna.description.packages import package_folders, resolve_uri


@pytest.fixture(autouse=True)
def no_ros(monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)


def put(folder: Path, text: str = "") -> Path:
    file = folder / "arm_description" / "meshes" / "hand.stl"
    file.parent.mkdir(parents=True)
    file.write_text(text)
    return file


URI = "package://arm_description/meshes/hand.stl"


def test_a_relative_path_in_a_variable_does_not_lead_into_the_current_folder(tmp_path, monkeypatch):
    put(tmp_path / "share")
    put(tmp_path / "cmeel.prefix" / "share")
    put(tmp_path)
    monkeypatch.chdir(tmp_path)
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.setenv(name, os.pathsep.join(["", ".", "./share", "../" + tmp_path.name]))
    monkeypatch.setattr(sys, "path", ["", ".", *sys.path])
    assert not [folder for folder in package_folders("arm_description", None) if folder.is_dir()]


def test_package_folders_are_searched_in_order(tmp_path, monkeypatch):
    above, description = tmp_path / "ws", tmp_path / "ws" / "src" / "robots"
    description.mkdir(parents=True)
    places = [tmp_path / "first", tmp_path / "second", tmp_path / "ros", tmp_path / "ament" / "share", above]
    places.append(tmp_path / "site" / "cmeel.prefix" / "share")
    files = [put(place) for place in places]
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(["", str(tmp_path / "nowhere"), str(tmp_path / "ros")]))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "ament"))
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site")])
    for file in files:
        found, _ = resolve_uri(URI, description, [tmp_path / "first", str(tmp_path / "second")])
        assert found is not None
        assert found.samefile(file)
        folders = package_folders("arm_description", description, [tmp_path / "first", tmp_path / "second"])
        assert next(filter(Path.is_dir, folders)).samefile(file.parents[1])
        file.unlink()
        file.parent.rmdir()
        file.parents[1].rmdir()
    assert resolve_uri(URI, description, [tmp_path / "first"])[0] is None
    assert not any(map(Path.is_dir, package_folders("arm_description", description, ())))


def test_a_package_without_the_file_does_not_hide_one_that_has_it(tmp_path):
    (tmp_path / "empty" / "arm_description").mkdir(parents=True)
    file = put(tmp_path / "full")
    assert resolve_uri(URI, None, [tmp_path / "empty", tmp_path / "full"])[0] == file


def test_a_package_dir_can_be_the_package_itself(tmp_path):
    file = put(tmp_path)
    assert resolve_uri(URI, None, [tmp_path / "arm_description"])[0] == file
    assert resolve_uri(URI, tmp_path / "arm_description" / "meshes")[0].samefile(file)


def test_a_folder_is_the_package_that_its_package_xml_names(tmp_path):
    file = put(tmp_path)
    clone = file.parents[1].rename(tmp_path / "clone-of-arm")
    assert resolve_uri(URI, None, [clone])[0] is None
    (clone / "package.xml").write_text("<package format='3'>\n  <name> arm_description </name>\n</package>")
    for place in ((None, [clone]), (clone / "meshes", [])):
        assert resolve_uri(URI, *place)[0].samefile(clone / "meshes" / "hand.stl")


def test_a_package_above_the_description_is_found_from_a_relative_folder(tmp_path, monkeypatch):
    file = put(tmp_path)
    (tmp_path / "arm_description" / "urdf").mkdir()
    monkeypatch.chdir(tmp_path / "arm_description")
    assert resolve_uri(URI, Path("urdf"))[0].samefile(file)


@pytest.mark.parametrize(
    "inside",
    [
        "../secret.stl",
        "meshes/../../secret.stl",
        "%2e%2e/secret.stl",
        "meshes/%2E%2E%2F..%2Fsecret.stl",
        "/{0}/secret.stl",
        "//{0}/secret.stl",
    ],
)
def test_a_path_cannot_leave_its_package(tmp_path, inside):
    put(tmp_path)
    (tmp_path / "secret.stl").write_text("secret")
    uri = f"package://arm_description/{inside.format(tmp_path)}"
    found, tried = resolve_uri(uri, None, [tmp_path])
    assert found is None
    assert all(
        path.resolve().is_relative_to((tmp_path / "arm_description").resolve()) or "arm_description" in path.parts
        for path in tried
    )


@pytest.mark.parametrize(
    "uri", ["package:///secret.stl", "package://../secret.stl", "package://./secret.stl", "package://%2e%2e/secret.stl"]
)
def test_a_uri_without_a_package_name_finds_no_file(tmp_path, uri):
    (tmp_path / "secret.stl").write_text("secret")
    (tmp_path / "packages").mkdir()
    found, _ = resolve_uri(uri, tmp_path / "packages", [tmp_path / "packages", tmp_path])
    assert found is None


def test_a_symbolic_link_in_a_package_is_followed_as_colcon_makes_them(tmp_path):
    file = put(tmp_path / "install")
    (tmp_path / "src").mkdir()
    source = file.rename(tmp_path / "src" / "hand.stl")
    file.symlink_to(source)
    assert resolve_uri(URI, None, [tmp_path / "install"])[0] == file


def test_dots_within_the_package_are_followed(tmp_path):
    file = put(tmp_path)
    found, _ = resolve_uri("package://arm_description/meshes/../meshes/hand.stl", None, [tmp_path])
    assert found is not None
    assert found.resolve() == file.resolve()


def test_a_space_in_a_name_can_be_percent_encoded(tmp_path):
    file = put(tmp_path)
    spaced = file.rename(file.with_name("my hand.stl"))
    for name in ("my hand.stl", "my%20hand.stl"):
        assert resolve_uri(f"package://arm_description/meshes/{name}", None, [tmp_path])[0] == spaced
        assert resolve_uri(f"file://{file.parent}/{name}", None)[0] == spaced


@pytest.mark.parametrize("name", ["hand#2.stl", "hand?.stl", "hand;1.stl", "50%.stl"])
def test_characters_special_in_urls_are_part_of_a_file_name(tmp_path, name):
    file = put(tmp_path)
    odd = file.rename(file.with_name(name))
    assert resolve_uri(f"package://arm_description/meshes/{name}", None, [tmp_path])[0] == odd
    assert resolve_uri(f"meshes/{name}", tmp_path / "arm_description")[0] == odd


def test_every_path_that_was_tried_is_listed(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    monkeypatch.setattr(sys, "path", [str(tmp_path / "site")])
    found, tried = resolve_uri(URI, None, [tmp_path / "given"])
    assert found is None
    folders = [tmp_path / "given", tmp_path / "ros", tmp_path / "site" / "cmeel.prefix" / "share"]
    assert tried == [folder / "arm_description" / "meshes" / "hand.stl" for folder in folders]


def test_a_plain_path_is_relative_to_the_description_and_then_to_package_dirs(tmp_path):
    file = put(tmp_path)
    found, tried = resolve_uri("meshes/hand.stl", tmp_path / "arm_description", [tmp_path])
    assert (found, tried) == (file, [file, tmp_path / "meshes" / "hand.stl"])
    assert resolve_uri("meshes/hand.stl", tmp_path, [tmp_path / "arm_description"])[0] == file
    assert resolve_uri("meshes/hand.stl", tmp_path)[0] is None
    assert resolve_uri(str(file), None)[0] == file


def test_a_folder_is_not_a_file(tmp_path):
    put(tmp_path)
    assert resolve_uri("package://arm_description/meshes", None, [tmp_path])[0] is None


MESH = "<mesh filename='package://myarm/meshes/hand.stl'/>"


@pytest.mark.parametrize(
    ("start", "given", "named"),
    [
        ("", [], "myarm/arm.urdf"),
        ("myarm", [], "arm.urdf"),
        ("myarm", ["."], "../robots/arm.urdf"),
        ("myarm/meshes", [".."], "../../robots/arm.urdf"),
        ("myarm/meshes", ["../.."], "../../robots/arm.urdf"),
        ("", ["myarm"], "robots/arm.urdf"),
        ("", ["."], "robots/arm.urdf"),
        ("robots", ["../myarm/../myarm"], "arm.urdf"),
    ],
)
def test_a_package_is_found_from_relative_package_dirs_and_the_description(tmp_path, monkeypatch, start, given, named):
    (tmp_path / "myarm" / "meshes").mkdir(parents=True)
    (tmp_path / "robots").mkdir()
    shape = f"<collision><geometry>{MESH}</geometry></collision>"
    for folder in ("myarm", "robots"):
        (tmp_path / folder / "arm.urdf").write_text(f'<robot name="r"><link name="a">{shape}</link></robot>')
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    facets = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
    lines = ["".join("vertex {} {} {}\n".format(*corners[k]) for k in facet) for facet in facets]
    text = "".join(f"facet normal 0 0 0\nouter loop\n{line}endloop\nendfacet\n" for line in lines)
    (tmp_path / "myarm" / "meshes" / "hand.stl").write_text(f"solid s\n{text}endsolid s\n")
    monkeypatch.chdir(tmp_path / start)
    robot = ulna.load(named, package_dirs=given)
    assert robot.with_convex_hulls().in_collision([]) is False
    assert not [finding for finding in ulna.inspect(named, package_dirs=given).findings if finding.tried]


def test_package_dirs_are_independent_of_a_later_change_of_folder(tmp_path, monkeypatch):
    file = put(tmp_path)
    monkeypatch.chdir(tmp_path)
    robot = ulna.load('<robot name="r"><link name="a"/></robot>', package_dirs=["."])
    monkeypatch.chdir("/")
    assert resolve_uri(URI, None, robot.description.package_dirs)[0] == file


@pytest.mark.parametrize("given", [[3], [None], "folder", 3])
def test_package_dirs_that_are_not_a_list_of_folders_are_refused(given):
    with pytest.raises(ulna.InputError, match="package_dirs: "):
        ulna.load("panda", package_dirs=given)
