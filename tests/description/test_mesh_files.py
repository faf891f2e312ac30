"""A description cannot make a program read mesh files outside its own folder, package and package_dirs."""

import pytest

import ulna
from ulna.description.meshes.mesh_files import MeshFiles
from ulna.description.packages import resolve_uri
from ulna.errors import FileError

URDF = '<robot name="a"><link name="l"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'


@pytest.fixture
def place(tmp_path):
    for name in ("robot/urdf/own.stl", "robot/meshes/arm.stl", "secret/key.stl", ".ssh/key.stl", "robot/urdf/notes.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("solid")
    (tmp_path / "robot/package.xml").write_text("<package><name>robot</name></package>")
    return tmp_path


def files(place, package_dirs=()):
    path = place / "robot/urdf/a.urdf"
    path.write_text(URDF.format("own.stl"))
    return MeshFiles(ulna.load(path, package_dirs=package_dirs).description)


@pytest.mark.parametrize("uri", ["own.stl", "./own.stl", "../meshes/arm.stl", "package://robot/meshes/arm.stl"])
def test_a_mesh_in_the_folder_or_the_package_is_found(place, uri):
    assert files(place).find(uri).resolve().name in ("own.stl", "arm.stl")


@pytest.mark.parametrize(
    "uri",
    [
        "../../secret/key.stl",
        "../../.ssh/key.stl",
        "..%2f..%2fsecret/key.stl",
        "package://robot/../secret/key.stl",
        "package://robot/%2e%2e/secret/key.stl",
        "package://../secret/key.stl",
        "package://.ssh/key.stl",
        "package://secret/key.stl",
        "file://{place}/secret/key.stl",
        "{place}/secret/key.stl",
        "file://{place}/robot/urdf/../../secret/key.stl",
    ],
)
def test_an_existing_mesh_outside_the_folders_is_refused(place, uri):
    with pytest.raises(FileError, match=r"not read|package_dirs"):
        files(place).find(uri.format(place=place))


@pytest.mark.parametrize("uri", ["linked.stl", "linked/key.stl", "package://robot/linked.stl", "package://linked/key.stl"])
def test_a_symbolic_link_out_of_the_folders_is_not_followed(place, uri):
    (place / "secret/package.xml").write_text("<package><name>hidden</name></package>")
    for folder in (place / "robot", place / "robot/urdf"):
        (folder / "linked.stl").symlink_to(place / "secret/key.stl")
    for folder in (place, place / "robot/urdf"):
        (folder / "linked").symlink_to(place / "secret")
    with pytest.raises(FileError, match=r"lies outside|is a link; if it is the right package"):
        files(place).find(uri)
    assert files(place, package_dirs=[place / "secret", place]).find(uri).is_file()


@pytest.mark.parametrize("uri", ["file:///etc/passwd", "/etc/passwd", "../../../../../../../etc/passwd", "notes.txt"])
def test_a_file_that_is_not_a_mesh_is_not_read(place, uri):
    with pytest.raises(FileError, match="not read as a mesh"):
        files(place).find(uri)


def test_package_dirs_allow_a_folder(place):
    assert files(place, package_dirs=[place / "secret"]).find("../../secret/key.stl").is_file()


def test_a_parent_folder_is_a_package_only_with_a_package_xml_or_a_folder_for_meshes(place):
    (place / "robot/package.xml").unlink()
    assert files(place).find("package://robot/meshes/arm.stl").is_file()
    (place / "robot/meshes").rename(place / "robot/parts")
    with pytest.raises(FileError, match=r"has no package\.xml; if it is the right package: package_dirs=\['.*robot'\]$"):
        files(place).find("package://robot/parts/arm.stl")
    assert files(place, package_dirs=[place / "robot"]).find("package://robot/parts/arm.stl").is_file()


def test_the_error_for_a_missing_mesh_lists_the_paths_tried(place):
    with pytest.raises(FileError, match=r"no such file; tried .*robot.urdf.nothing\.stl"):
        files(place).find("nothing.stl")


def test_names_that_file_systems_do_not_allow_are_refused(place):
    for uri in ("\0.stl", "x" * 5000 + ".stl", "package://robot/\0.stl"):
        with pytest.raises(FileError):
            files(place).find(uri)


def test_a_mesh_may_refer_only_to_files_beside_it(place):
    found = files(place)
    mesh = found.find("own.stl")
    assert found.beside(mesh, "notes.txt").is_file()
    with pytest.raises(FileError, match="lies outside"):
        found.beside(mesh, "../../secret/key.stl")


def test_a_description_given_as_text_has_no_readable_folder(tmp_path):
    there = tmp_path / "x.stl"
    there.touch()
    text = MeshFiles(ulna.load(URDF.format("x.stl")).description)
    with pytest.raises(FileError, match="lies outside"):
        text.find(str(there))


@pytest.mark.parametrize(
    ("uri", "name"),
    [
        ("a%20b.stl", "a%20b.stl"),
        ("a%20b.stl", "a b.stl"),
        ("file://a%20b.stl", "a b.stl"),
        ("package://robot/urdf/a%20b.stl", "a b.stl"),
    ],
)
def test_mesh_files_and_resolve_uri_find_the_same_file(place, uri, name):
    mesh = place / "robot/urdf" / name
    mesh.write_text("solid")
    found = files(place)
    assert found.find(uri).samefile(mesh)
    path, _ = resolve_uri(uri, found.folder)
    assert path is not None
    assert path.samefile(mesh)
