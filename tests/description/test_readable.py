"""What a xacro document may reach: the files of its folder, its package and ``package_dirs``; and nothing else on the machine."""

import os
from pathlib import Path

import pytest

import ulna
from ulna import DescriptionError, InputError

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


def test_yaml_in_a_given_folder_is_read(tmp_path):
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


def test_an_include_outside_is_not_read_even_if_it_is_optional(tmp_path):
    put(tmp_path / "out" / "part.xacro", '<link name="secret"/>')
    file = put(
        tmp_path / "in" / "r.xacro", '<xacro:include filename="../out/part.xacro" optional="true"/>', '<link name="${1}"/>'
    )
    with pytest.raises(DescriptionError, match="lies outside"):
        ulna.load(file)


def test_the_package_of_a_document_may_be_read_from_its_beginning(tmp_path):
    put_yaml(tmp_path / "arm" / "config" / "c.yaml", "found")
    (tmp_path / "arm" / "package.xml").write_text("<package/>")
    assert ulna.load(put(tmp_path / "arm" / "urdf" / "r.xacro", link("../config/c.yaml"))).link_names == ("found",)


def test_a_folder_above_counts_as_a_package_only_with_its_package_xml(tmp_path):
    put_yaml(tmp_path / "private" / "keys.yaml", "key")
    file = put(tmp_path / "in" / "r.xacro", link("$(find private)/keys.yaml"))
    with pytest.raises(
        DescriptionError, match=r"\$\(find private\): .*private has no package.xml; if it is the one, name its folder"
    ):
        ulna.load(file)
    (tmp_path / "private" / "package.xml").write_text("<package/>")
    assert ulna.load(file).link_names == ("key",)


@pytest.mark.parametrize("name", ["..", ".ssh", "a/../../b", "/etc", ""])
def test_a_package_has_a_name_and_not_a_path(tmp_path, name):
    file = put(tmp_path / "r.xacro", f'<xacro:include filename="$(find {name})/x.xacro"/>')
    with pytest.raises(DescriptionError, match=r"is no package's name|accepts exactly one argument"):
        ulna.load(file, package_dirs=[tmp_path])


def test_an_include_may_be_a_package_address_as_in_meshes(tmp_path):
    put(tmp_path / "ws" / "gripper" / "g.xacro", '<link name="g"/>')
    file = put(tmp_path / "in" / "r.xacro", '<xacro:include filename="package://gripper/g.xacro"/>')
    assert ulna.load(file, package_dirs=[tmp_path / "ws"]).link_names == ("g",)
    with pytest.raises(DescriptionError, match=r"\$\(find gripper\): no such package in package_dirs"):
        ulna.load(file)


def test_a_pattern_lists_only_what_may_be_read(tmp_path):
    for name in "ab":
        put(tmp_path / "in" / "parts" / f"{name}.xacro", f'<link name="{name}"/>')
    file = put(tmp_path / "in" / "r.xacro", '<xacro:include filename="parts/[a]*.xacro"/>')
    assert ulna.load(file).link_names == ("a",)
    put(tmp_path / "out" / "c.xacro", '<link name="c"/>')
    with pytest.raises(DescriptionError, match="lies outside"):
        ulna.load(put(file, '<xacro:include filename="../out/*.xacro"/>'))


def test_the_folder_of_a_document_has_its_name_in_it(tmp_path):
    put_yaml(tmp_path / "a.yaml", "a")
    assert ulna.load(put(tmp_path / "r.xacro", link("$(dirname)/a.yaml"))).link_names == ("a",)


@pytest.mark.parametrize("how", ["a file", "a folder", "a package above"])
def test_a_link_is_read_where_it_leads_to(tmp_path, how):
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
    with pytest.raises(DescriptionError, match=r"lies outside the document's folder|linked is a link; if it is the one"):
        ulna.load(file)
    assert ulna.load(file, package_dirs=[tmp_path / "private"]).link_names == ("key",)


def test_the_links_of_an_installed_package_are_followed(tmp_path, monkeypatch):
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
def test_what_is_no_regular_file_is_not_waited_for(tmp_path, special):
    name = special
    if special == "a pipe":
        os.mkfifo(tmp_path / "p.yaml")
        name = "p.yaml"
    if special == "a folder":
        name = "."
    file = put(tmp_path / "r.xacro", link(name))
    with pytest.raises(DescriptionError, match=r"not a regular file|Is a directory|lies outside"):
        ulna.load(file, package_dirs=["/dev"])


def test_an_optional_include_that_is_not_there_is_passed_over(tmp_path):
    file = put(tmp_path / "r.xacro", '<xacro:include filename="gone.xacro" optional="true"/>', '<link name="${1}"/>')
    assert ulna.load(file).link_names == ("1",)


def test_an_environment_variable_is_not_read_but_may_be_given(tmp_path, monkeypatch):
    monkeypatch.setenv("SIDE", "of the user")
    file = put(tmp_path / "r.xacro", '<link name="$(env SIDE)"/>')
    with pytest.raises(DescriptionError, match=r"\$\(env SIDE\): .* no environment variables; give SIDE in xacro_args$"):
        ulna.load(file)
    assert ulna.load(file, xacro_args={"SIDE": "left"}).link_names == ("left",)
    file = put(tmp_path / "r.xacro", '<link name="$(optenv SIDE right)"/>')
    assert ulna.load(file).link_names == ("right",)
    assert ulna.load(file, xacro_args={"SIDE": "left"}).link_names == ("left",)


ARGUMENTS = ['<xacro:arg name="prefix" default="a"/>', '<link name="$(arg prefix)"/>']


def test_an_argument_that_a_document_does_not_know_is_refused_with_a_near_name(tmp_path):
    file = put(tmp_path / "r.xacro", *ARGUMENTS)
    with pytest.raises(InputError, match=r"^xacro_args: r\.xacro has no argument 'prefx'; did you mean 'prefix'\?$"):
        ulna.load(file, xacro_args={"prefx": "b"})
    with pytest.raises(InputError, match=r"^xacro_args: r\.xacro has no argument 'zz'; the only one is 'prefix'$"):
        ulna.load(file, xacro_args={"prefix": "b", "zz": "b"})


def test_arguments_of_includes_and_those_behind_a_condition_are_known(tmp_path):
    put(tmp_path / "part.xacro", *ARGUMENTS)
    lines = ['<xacro:if value="0"><xacro:arg name="never" default="1"/></xacro:if>', '<xacro:include filename="part.xacro"/>']
    file = put(tmp_path / "r.xacro", *lines)
    assert ulna.load(file, xacro_args={"prefix": "b", "never": 2}).link_names == ("b",)


def test_an_argument_without_a_declaration_is_known_where_it_is_used(tmp_path):
    file = put(tmp_path / "r.xacro", "<link name=\"${xacro.arg('n')}\"/>")
    assert ulna.load(file, xacro_args={"n": "b"}).link_names == ("b",)
