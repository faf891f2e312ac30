"""Python files and libraries that a stranger puts beside a document: the child process that expands it runs none of them."""

import json
import sys
from pathlib import Path

import pytest

import ulna
from ulna.description.child_process import child_process

RUNS = "import pathlib; pathlib.Path({mark!r}).touch()\n"
DOCUMENT = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="l${1}"/></robot>'
MODULES = ("sitecustomize", "usercustomize", "json", "types", "xacro", "ament_index_python")
SAYS_WHERE = "import json, os, sys; print(json.dumps([os.getcwd(), sys.path, sys.flags.isolated, dict(os.environ)]))"


@pytest.fixture
def document(tmp_path, monkeypatch):
    """A document in a folder of a folder; in each of the three folders, which the process is in, lie the stranger's files."""
    folder = tmp_path / "downloads" / "robot"
    (folder / "lib").mkdir(parents=True)
    for place in (tmp_path, folder.parent, folder, folder / "lib"):
        plant(place, tmp_path / "mark")
    (folder / "r.xacro").write_text(DOCUMENT)
    monkeypatch.chdir(tmp_path)
    return folder / "r.xacro"


def plant(place: Path, mark: Path) -> None:
    """Modules that leave a mark, and files with the names of this process's libraries, which no loader can load."""
    for name in MODULES:
        (place / f"{name}.py").write_text(RUNS.format(mark=str(mark)))
    for name in libraries():
        (place / name).write_text("no library")


def libraries() -> set[str]:
    maps = Path("/proc/self/maps")
    words = maps.read_text().split() if maps.exists() else []
    return {Path(word).name for word in words if word.startswith("/") and ".so" in word} | {"libffi.so.8", "libc.so.6"}


def assert_nothing_planted_is_run(document: Path) -> None:
    assert ulna.load(document).link_names == ("l1",)
    assert not list(document.parents[2].glob("**/mark"))


@pytest.mark.process
@pytest.mark.parametrize("entry", ["", ".", "..", "lib", "downloads/robot", "ABSOLUTE"])
@pytest.mark.parametrize("at", [0, 1000])
def test_no_module_is_imported_from_the_folder_of_a_document(document, monkeypatch, entry, at):
    path = list(sys.path)
    path.insert(at, str(document.parent) if entry == "ABSOLUTE" else entry)
    monkeypatch.setattr(sys, "path", path)
    assert_nothing_planted_is_run(document)


@pytest.mark.process
@pytest.mark.parametrize("variable", ["LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH"])
@pytest.mark.parametrize("value", ["", ":/opt/x", "/opt/x:", "/opt/x::/opt/y", "/opt/x;", ";", ".", "..", "lib", "/opt/x:lib"])
def test_no_library_is_loaded_from_the_folder_of_a_document(document, monkeypatch, variable, value):
    monkeypatch.setenv(variable, value)
    assert_nothing_planted_is_run(document)


@pytest.mark.process
@pytest.mark.parametrize("variable", ["PYTHONHOME", "PYTHONSTARTUP", "PYTHONUSERBASE", "PYTHONPATH", "LD_PRELOAD", "LD_AUDIT"])
def test_no_variable_of_python_or_of_the_loader_leads_to_the_folder_of_a_document(document, monkeypatch, variable):
    monkeypatch.setenv(variable, str(document.parent))
    assert_nothing_planted_is_run(document)


def test_a_child_process_is_isolated_in_an_empty_folder_of_its_own_and_has_absolute_paths_only(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", ["", "lib", Path("lib"), *sys.path, str(tmp_path)])
    monkeypatch.setenv("LD_LIBRARY_PATH", ":/opt/x;/opt/y:lib")
    with child_process(SAYS_WHERE, 1 << 31, 20) as (child, _):
        folder, paths, isolated, environment = json.loads(child.communicate()[0])
    assert isolated
    assert not Path(folder).exists(), "it is removed with the process"
    assert Path(folder) != Path.cwd()
    assert all(Path(path).is_absolute() for path in paths)
    assert not [name for name in environment if name.startswith("PYTHON")]
    assert environment["LD_LIBRARY_PATH"] == "/opt/x:/opt/y"
