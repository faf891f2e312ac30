"""The files that a xacro document can read: those of its folder, its package and ``package_dirs``, and no others."""

import glob
import os
from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError, DescriptionWarning
from ulna.description.readable import Readable

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


def put(file: Path, *lines: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join([f'<robot name="r" {NAMESPACE}>', *lines, "</robot>"]))
    return file


def put_yaml(file: Path, name: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"name: {name}\n")
    return file


def link(path: object) -> str:
    return f'<link name="{name_in(path)}"/>'


def name_in(path: object) -> str:
    return f"${{xacro.load_yaml('{path}')['name']}}"


def test_yaml_is_read_beside_the_document_and_below_it(tmp_path):
    put_yaml(tmp_path / "a.yaml", "a")
    put_yaml(tmp_path / "more" / "b.yaml", "b")
    paths = "a.yaml", "more/b.yaml", "more/../a.yaml"
    file = put(tmp_path / "r.xacro", f'<link name="{"".join(name_in(path) for path in paths)}"/>')
    assert ulna.load(file).link_names == ("aba",)


def test_yaml_in_package_dirs_is_read(tmp_path):
    secret = put_yaml(tmp_path / "there" / "s.yaml", "found")
    file = put(tmp_path / "here" / "r.xacro", link(secret))
    assert ulna.load(file, package_dirs=[tmp_path / "there"]).link_names == ("found",)
    assert ulna.load(file.read_text(), package_dirs=[tmp_path / "there"]).link_names == ("found",)


@pytest.mark.parametrize("how", ["absolute", "with dots", "beside a folder of like name", "from text", "as an address"])
def test_a_file_outside_is_not_read(tmp_path, how):
    secret = put_yaml(tmp_path / "here too" / "secret.yaml", "secret")
    path = {"with dots": "../here too/secret.yaml", "as an address": f"file://{secret}"}.get(how, secret)
    file = put(tmp_path / "here" / "r.xacro", link(path))
    with pytest.raises(DescriptionError, match=r"xacro: reads .*secret\.yaml, which lies outside the document's folder"):
        ulna.load(file.read_text() if how == "from text" else file)


def test_an_optional_include_outside_is_refused(tmp_path):
    put(tmp_path / "out" / "part.xacro", '<link name="secret"/>')
    file = put(
        tmp_path / "in" / "r.xacro", '<xacro:include filename="../out/part.xacro" optional="true"/>', '<link name="${1}"/>'
    )
    with pytest.raises(DescriptionError, match="lies outside"):
        ulna.load(file)


def test_the_whole_package_of_a_document_can_be_read(tmp_path):
    put_yaml(tmp_path / "arm" / "config" / "c.yaml", "found")
    (tmp_path / "arm" / "package.xml").write_text("<package/>")
    assert ulna.load(put(tmp_path / "arm" / "urdf" / "r.xacro", link("../config/c.yaml"))).link_names == ("found",)


def test_a_parent_folder_is_a_package_only_with_a_package_xml(tmp_path):
    put_yaml(tmp_path / "private" / "keys.yaml", "key")
    file = put(tmp_path / "in" / "r.xacro", link("$(find private)/keys.yaml"))
    with pytest.raises(
        DescriptionError, match=r"\$\(find private\): .*private has no package.xml; if it is the right package: package_dirs="
    ):
        ulna.load(file)
    (tmp_path / "private" / "package.xml").write_text("<package/>")
    assert ulna.load(file).link_names == ("key",)


@pytest.mark.parametrize("name", ["..", ".ssh", "a/../../b", "/etc", ""])
def test_a_package_name_that_is_a_path_is_refused(tmp_path, name):
    file = put(tmp_path / "r.xacro", f'<xacro:include filename="$(find {name})/x.xacro"/>')
    with pytest.raises(DescriptionError, match=r"is not the name of a package|accepts exactly one argument"):
        ulna.load(file, package_dirs=[tmp_path])


def test_an_include_can_be_a_package_uri(tmp_path):
    put(tmp_path / "ws" / "gripper" / "g.xacro", '<link name="g"/>')
    file = put(tmp_path / "in" / "r.xacro", '<xacro:include filename="package://gripper/g.xacro"/>')
    assert ulna.load(file, package_dirs=[tmp_path / "ws"]).link_names == ("g",)
    with pytest.raises(DescriptionError, match=r"\$\(find gripper\): no such package in package_dirs"):
        ulna.load(file)


def test_a_glob_pattern_lists_only_readable_files(tmp_path):
    for name in "ab":
        put(tmp_path / "in" / "parts" / f"{name}.xacro", f'<link name="{name}"/>')
    file = put(tmp_path / "in" / "r.xacro", '<xacro:include filename="parts/[a]*.xacro"/>')
    assert ulna.load(file).link_names == ("a",)
    put(tmp_path / "out" / "c.xacro", '<link name="c"/>')
    with pytest.raises(DescriptionError, match="lies outside"):
        ulna.load(put(file, '<xacro:include filename="../out/*.xacro"/>'))


def test_dirname_is_the_folder_of_the_document(tmp_path):
    put_yaml(tmp_path / "a.yaml", "a")
    assert ulna.load(put(tmp_path / "r.xacro", link("$(dirname)/a.yaml"))).link_names == ("a",)


@pytest.mark.parametrize("how", ["a file", "a folder", "a package above"])
def test_a_symbolic_link_is_checked_by_its_target(tmp_path, how):
    put_yaml(tmp_path / "private" / "keys.yaml", "key")
    (tmp_path / "private" / "package.xml").write_text("<package/>")
    (tmp_path / "in").mkdir()
    link_at, target, name = {
        "a file": ("in/linked.yaml", "private/keys.yaml", "linked.yaml"),
        "a folder": ("in/linked", "private", "linked/keys.yaml"),
        "a package above": ("linked", "private", "$(find linked)/keys.yaml"),
    }[how]
    (tmp_path / link_at).symlink_to(tmp_path / target)
    file = put(tmp_path / "in" / "r.xacro", link(name))
    with pytest.raises(
        DescriptionError, match=r"lies outside the document's folder|linked is a link; if it is the right package"
    ):
        ulna.load(file)
    assert ulna.load(file, package_dirs=[tmp_path / "private"]).link_names == ("key",)


def test_symbolic_links_of_an_installed_package_are_followed(tmp_path, monkeypatch):
    """``colcon build --symlink-install`` makes every file a link to its source."""
    source = put_yaml(tmp_path / "src" / "arm" / "c.yaml", "found")
    share = tmp_path / "install" / "share" / "arm"
    share.mkdir(parents=True)
    (share / "c.yaml").symlink_to(source)
    file = put(tmp_path / "in" / "r.xacro", link("$(find arm)/c.yaml"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert ulna.load(file).link_names == ("found",)
    with pytest.raises(DescriptionError, match="lies outside"):
        ulna.load(put(file, link("$(find arm)/../arm/c.yaml")))


@pytest.mark.parametrize("special", ["/dev/zero", "/dev/stdin", "a pipe", "a folder"])
def test_a_device_a_pipe_or_a_folder_is_refused_at_once(tmp_path, special):
    name = special
    if special == "a pipe":
        os.mkfifo(tmp_path / "p.yaml")
        name = "p.yaml"
    if special == "a folder":
        name = "."
    file = put(tmp_path / "r.xacro", link(name))
    with pytest.raises(DescriptionError, match=r"not a regular file|Is a directory|lies outside"):
        ulna.load(file, package_dirs=["/dev"])


def test_a_missing_optional_include_is_skipped(tmp_path):
    file = put(tmp_path / "r.xacro", '<xacro:include filename="gone.xacro" optional="true"/>', '<link name="${1}"/>')
    assert ulna.load(file).link_names == ("1",)


def test_environment_variables_are_not_read_but_can_be_given_in_xacro_args(tmp_path, monkeypatch):
    monkeypatch.setenv("SIDE", "of the user")
    file = put(tmp_path / "r.xacro", '<link name="$(env SIDE)"/>')
    with pytest.raises(DescriptionError, match=r"\$\(env SIDE\): .* no environment variables; give SIDE in xacro_args$"):
        ulna.load(file)
    assert ulna.load(file, xacro_args={"SIDE": "left"}).link_names == ("left",)
    file = put(tmp_path / "r.xacro", '<link name="$(optenv SIDE right)"/>')
    assert ulna.load(file).link_names == ("right",)
    assert ulna.load(file, xacro_args={"SIDE": "left"}).link_names == ("left",)


ARGUMENTS = ['<xacro:arg name="prefix" default="a"/>', '<link name="$(arg prefix)"/>']


def test_an_undeclared_argument_is_warned_of_with_a_suggestion_as_launch_files_of_makers_pass_some(tmp_path):
    file = put(tmp_path / "r.xacro", *ARGUMENTS)
    nothing = "so its value in xacro_args has no effect"
    with pytest.warns(DescriptionWarning, match=rf"^r\.xacro has no argument 'prefx', {nothing}; did you mean 'prefix'\?$"):
        assert ulna.load(file, xacro_args={"prefx": "b"}).link_names == ("a",)
    with pytest.warns(DescriptionWarning, match=rf"^r\.xacro has no argument 'zz', {nothing}; the only one is 'prefix'$"):
        assert ulna.load(file, xacro_args={"prefix": "b", "zz": "b"}).link_names == ("b",)


def test_arguments_of_includes_and_of_false_conditions_are_accepted(tmp_path):
    put(tmp_path / "part.xacro", *ARGUMENTS)
    lines = ['<xacro:if value="0"><xacro:arg name="never" default="1"/></xacro:if>', '<xacro:include filename="part.xacro"/>']
    file = put(tmp_path / "r.xacro", *lines)
    assert ulna.load(file, xacro_args={"prefix": "b", "never": 2}).link_names == ("b",)


def test_an_argument_that_is_used_without_a_declaration_is_accepted(tmp_path):
    file = put(tmp_path / "r.xacro", "<link name=\"${xacro.arg('n')}\"/>")
    assert ulna.load(file, xacro_args={"n": "b"}).link_names == ("b",)


PATTERNS = (
    "*.xacro",
    "*",
    "?.yaml",
    "*/*",
    "*/b.yaml",
    "more/*",
    "*/.*",
    ".*",
    "[ab].*",
    "*/[!b]*",
    "m*e/b*",
    "none*/*",
    "*/*/*",
    "./*.yaml",
    "a.yaml",
)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_pattern_finds_what_python_finds(tmp_path, pattern):
    for name in (
        "a.yaml",
        "b.yaml",
        ".hidden.yaml",
        "a.xacro",
        "[ab].yaml",
        "more/b.yaml",
        "more/.c",
        "more/deep/d.yaml",
        "other/e",
    ):
        put_yaml(tmp_path / name, "x")
    (tmp_path / "loop").symlink_to(".")
    (tmp_path / "broken").symlink_to("nowhere")
    found = Readable(tmp_path, []).matching(f"{tmp_path}/{pattern}")
    assert found == sorted(str(Path(path)) for path in glob.glob(f"{tmp_path}/{pattern}"))  # noqa: PTH207


def test_a_pattern_through_links_to_its_own_folder_is_refused_after_a_number_of_names(tmp_path):
    """Ten links and nine stars are 10^9 names."""
    for k in range(10):
        (tmp_path / f"l{k}").symlink_to(".")
    file = put(tmp_path / "r.xacro", f'<xacro:include filename="{"*/" * 9}n*.xacro"/>', '<link name="l"/>')
    with pytest.raises(DescriptionError, match=r"reads .*, for which more than 100000 names would be compared$"):
        ulna.load(file)
