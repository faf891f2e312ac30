"""Robots by name, from two packages that are imitated here. Their files are read; they are never imported and never download."""

import sys
from pathlib import Path

import pytest

import ulna
import ulna.description.meshes.reader
from ulna import FileError

URDF = '<robot name="{0}"><link name="{0}"/></robot>'
XACRO = (
    '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="$(find arm_pkg)/part.xacro"/></robot>'
)
PART = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="$(arg side)"/></robot>'
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
MESHES = f'<robot name="r"><link name="l">{MESH.format("ball.stl")}{MESH.format("package://arm_pkg/ball.stl")}</link></robot>'
BALL = "solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid b\n"
REPOSITORIES = """
from dataclasses import dataclass
@dataclass
class Repository:
    cache_path: str
    commit: str
    url: str
REPOSITORIES = {"arms": Repository("arms", "abc", "https://nowhere.invalid/arms.git")}
"""
MODULE = """
from os import getenv as _getenv
from os import path as _path
from ._cache import clone_to_cache as _clone_to_cache
REPOSITORY_PATH: str = _clone_to_cache("arms", commit=_getenv("ROBOT_DESCRIPTION_COMMIT", None))
PACKAGE_PATH: str = _path.join(REPOSITORY_PATH, "package")
"""
MODULES = {
    "kr6_description": MODULE + 'URDF_PATH: str = _path.join(PACKAGE_PATH, "kr6.urdf")',
    "sided_description": MODULE + 'XACRO_PATH = _path.join(PACKAGE_PATH, "sided.xacro")\nXACRO_ARGS = {"side": "left"}',
    "ball_mj_description": MODULE + 'MJCF_PATH: str = _path.join(PACKAGE_PATH, "ball.xml")',
    "broken_description": MODULE + "URDF_PATH = 1 / 0",
}
EXAMPLES = [
    "ur_description/urdf/ur5_robot",
    "talos_data/robots/talos_reduced",
    "talos_data/robots/talos_full",
    "hyq_description/urdf/hyq_x",
]


def put(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


@pytest.fixture(autouse=True)
def nothing_else_installed(tmp_path, monkeypatch):
    """Only the two imitated packages are installed, and importing them raises."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.setattr(sys, "path", [str(site), *(p for p in sys.path if "site-packages" not in p)])
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "ROBOT_DESCRIPTION_COMMIT"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    return site


@pytest.fixture
def examples(nothing_else_installed):
    for name in EXAMPLES:
        put(
            nothing_else_installed / "cmeel.prefix/share/example-robot-data/robots" / f"{name}.urdf", URDF.format(Path(name).name)
        )


@pytest.fixture
def descriptions(nothing_else_installed):
    package = nothing_else_installed / "robot_descriptions"
    put(package / "__init__.py", "raise SystemExit('imported')")
    put(package / "_cache.py", "raise SystemExit('would download')")
    put(package / "_repositories.py", REPOSITORIES)
    for name, text in MODULES.items():
        put(package / f"{name}.py", text)


@pytest.fixture
def cache(tmp_path):
    put(tmp_path / "cache/arms/package/kr6.urdf", URDF.format("kr6"))
    put(tmp_path / "cache/arms/package/package.xml", "<package><name>arm_pkg</name></package>")
    put(tmp_path / "cache/arms/package/sided.xacro", XACRO)
    put(tmp_path / "cache/arms/package/part.xacro", PART)


@pytest.mark.parametrize(
    ("name", "robot"),
    [
        ("ur5_robot", "ur5_robot"),
        ("ur5", "ur5_robot"),
        ("talos", "talos_reduced"),
        ("talos_full", "talos_full"),
        ("hyq", "hyq_x"),
    ],
)
def test_a_robot_of_example_robot_data_has_its_file_name_and_a_short_name(examples, name, robot):
    assert ulna.load(name).name == robot


@pytest.mark.parametrize("name", ["kr6", "kr6_description"])
def test_a_cached_robot_is_loaded_without_importing_robot_descriptions(descriptions, cache, name):
    assert ulna.load(name).name == "kr6"
    assert "robot_descriptions" not in sys.modules


def test_a_cached_xacro_robot_has_default_arguments_that_can_be_overridden(descriptions, cache):
    assert ulna.load("sided").link_names == ("left",)
    assert ulna.load("sided", xacro_args={"side": "right"}).link_names == ("right",)


def test_the_meshes_of_a_robot_by_name_are_found_beside_its_description(descriptions, cache, tmp_path):
    put(tmp_path / "cache/arms/package/ball.stl", BALL)
    put(tmp_path / "cache/arms/package/kr6.urdf", MESHES)
    assert [finding.message for finding in ulna.inspect("kr6").findings] == ["no link has a collision shape"]


def test_a_commit_in_the_environment_selects_another_copy(descriptions, cache, tmp_path, monkeypatch):
    put(tmp_path / "cache/arms-123/arms/package/kr6.urdf", URDF.format("older"))
    monkeypatch.setenv("ROBOT_DESCRIPTION_COMMIT", "123")
    assert ulna.load("kr6").name == "older"


def test_a_robot_that_is_not_downloaded_is_an_error_with_the_command_that_downloads_it(descriptions, tmp_path):
    with pytest.raises(FileError) as caught:
        ulna.load("kr6")
    missing = tmp_path / "cache" / "arms"
    pull = "python -m robot_descriptions pull kr6_description downloads it"
    assert str(caught.value) == f"kr6: robot_descriptions knows it, but {missing} is not there; {pull}"


def test_a_module_that_cannot_be_read_is_named(descriptions, cache):
    with pytest.raises(FileError, match=r"broken_description\.py: cannot be read \(ZeroDivisionError: division by zero\)$"):
        ulna.load("broken")


@pytest.mark.parametrize("name", ["ball_mj", "ball"])
def test_a_robot_without_a_urdf_is_not_listed(descriptions, cache, name):
    with pytest.raises(FileError, match=r"^ball.*and not a robot's name"):
        ulna.load(name)


def test_example_robot_data_comes_before_the_cache(examples, descriptions, cache, nothing_else_installed):
    put(nothing_else_installed / "cmeel.prefix/share/example-robot-data/robots/kr_description/kr6.urdf", URDF.format("example"))
    assert ulna.load("kr6").name == "example"


def test_a_file_comes_before_a_package_robot_of_the_same_name(examples, tmp_path):
    put(tmp_path / "ur5", URDF.format("mine"))
    assert ulna.load("ur5").name == "mine"


def test_similar_names_are_suggested_with_their_packages(examples, descriptions):
    near = "'ur' (example-robot-data) or 'ur16e' (bundled) or 'ur5' (example-robot-data) or 'kr6' (robot_descriptions)"
    with pytest.raises(FileError) as caught:
        ulna.load("ur6")
    assert str(caught.value) == f"ur6: no such file; and not a robot's name; did you mean {near}?"
    with pytest.raises(FileError, match=r"did you mean 'panda' \(bundled\)\?$"):
        ulna.load("pandaa")
    with pytest.raises(FileError, match=r"names are known, none of them similar; `ulna list` prints them$"):
        ulna.load("zzzzzzzz")


def test_without_the_packages_the_error_says_how_to_install_them():
    with pytest.raises(FileError, match=r"did you mean .*; for more robots: pip install example-robot-data robot_descriptions$"):
        ulna.load("pandaa")


@pytest.mark.parametrize("source", ["ur5.urdf", "./ur5", "robots/ur5"])
def test_a_path_is_never_taken_for_a_name(examples, source):
    with pytest.raises(FileError, match=r"no such file$"):
        ulna.load(source)
