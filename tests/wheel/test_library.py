"""What is said where machine code cannot be used: a CPU too low, a file that is damaged or missing, a level that there is not."""

import json
import os
import pkgutil
import shutil
import subprocess
import sys
from importlib.metadata import files
from pathlib import Path

import pytest

import ulna
from ulna import FileError, InputError, UlnaError
from ulna.engine import _calls, ahead

AGAIN = r"install it again, or use a copy of the repository, where Numba compiles for this machine: pip install -e"
LEVELS = json.loads((ahead.FOLDER / ahead.INDEX).read_text())["levels"]


@pytest.fixture
def folder(tmp_path):
    """A copy of the machine code."""
    return shutil.copytree(ahead.FOLDER, tmp_path / "machine_code")


@pytest.mark.parametrize("module", ["numba", "subprocess", "urllib.request", "asyncio"])
def test_first_answers_need_no_compiler_and_little_else(module):
    ask = "T = p.forward_kinematics(p.home); p.inverse_kinematics(T), p.jacobian(p.home), p.in_collision(p.home)"
    code = f"import sys, ulna; p = ulna.load('panda'); {ask}; print({module!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


OF_OTHERS = "ulna.engine.", "ulna.demo.ros", "ulna.torch", "ulna.jax", "ulna.learning.tensors", "ulna.learning.callbacks"


def test_only_the_engine_needs_a_compiler():
    names = [m.name for m in pkgutil.walk_packages(ulna.__path__, "ulna.")]
    modules = [name for name in names if not name.startswith(OF_OTHERS)]  # the others need ROS, PyTorch or JAX
    code = "import importlib, sys; [importlib.import_module(name) for name in sys.argv[1:]]"
    subprocess.run([sys.executable, "-c", code, *modules], check=True)
    assert len(modules) > 200


def test_the_highest_level_that_the_cpu_has_is_used_and_a_lower_one_can_be_asked_for(folder):
    possible = [name for name, level in LEVELS.items() if level["needs"] <= _calls.x86_level()]
    assert ahead.load_library(folder, "").level == possible[-1]
    assert [ahead.load_library(folder, name).level for name in possible] == possible


@pytest.mark.parametrize("level", ["x86-64-v9", "v3", "haswell"])
def test_a_level_that_there_is_not_is_refused_by_name(folder, level):
    with pytest.raises(InputError, match=rf"^ULNA_CPU: '{level}'; the environment variable must be one of .*, native$"):
        ahead.load_library(folder, level)


def test_a_level_above_the_cpu_is_refused_by_name(folder, monkeypatch):
    monkeypatch.setattr(_calls, "x86_level", lambda: 2)
    with pytest.raises(InputError, match=r"^ULNA_CPU: 'x86-64-v3'; .* x86-64-v2, native$"):
        ahead.load_library(folder, "x86-64-v3")


def test_a_cpu_below_the_lowest_level_is_said_and_the_source_install_named(folder, monkeypatch):
    monkeypatch.setattr(_calls, "x86_level", lambda: 1)
    with pytest.raises(UlnaError, match=r"^this wheel needs a CPU of the level x86-64-v2 at least.*a copy of the repository"):
        ahead.load_library(folder, "")


def cut(file):
    replace(file, file.read_bytes()[:5000])


def overwrite(file):
    replace(file, b"\0" * file.stat().st_size)


def clear_the_end(file):
    """As a crash may leave it: loaded, it would end the process."""
    content = file.read_bytes()
    replace(file, content[:100] + b"\0" * (len(content) - 100))


def replace(file, content):
    """By a new file: the old one may be loaded, and what is written into a loaded library is called when the process ends."""
    file.unlink()
    file.write_bytes(content)


DAMAGES = {"cut": cut, "overwritten": overwrite, "end cleared": clear_the_end, "removed": lambda file: file.unlink()}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("what", ["library", "index"])
def test_a_damaged_or_missing_file_is_an_error_that_says_what_to_do(folder, damage, what):
    damage(folder / (LEVELS["x86-64-v2"]["file"] if what == "library" else ahead.INDEX))
    with pytest.raises(FileError, match=rf"^{folder}.*cannot be loaded .*{AGAIN}"):
        ahead.load_library(folder, "x86-64-v2").find("kinematics.entries.forward.forward_one")


def test_no_other_folder_is_looked_into(tmp_path):
    """Neither the current folder, nor PYTHONPATH's, nor the loader's."""
    for file in ahead.FOLDER.iterdir():
        (tmp_path / file.name).write_bytes(b"")
    code = "import ulna; p = ulna.load('panda'); p.forward_kinematics(p.home)"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "LD_LIBRARY_PATH": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path, env=environment)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_no_memory_is_both_writable_and_executable():
    code = (
        "import ulna; p = ulna.load('panda'); p.in_collision(p.home)\n"
        "print(*[line.split()[1] for line in open('/proc/self/maps')])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert not [flags for flags in said.split() if "w" in flags and "x" in flags]


def test_the_hash_of_a_library_is_computed_once_on_a_machine(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    computed, whole = [], ahead._hash_is
    monkeypatch.setattr(ahead, "_hash_is", lambda *given: computed.append(given) or whole(*given))
    for _ in range(3):
        ahead.load_library(folder, "x86-64-v2")
    assert len(computed) == 1
    clear_the_end(folder / LEVELS["x86-64-v2"]["file"])  # what was whole before is looked at again, since its time has changed
    with pytest.raises(FileError, match="its hash differs"):
        ahead.load_library(folder, "x86-64-v2")


@pytest.mark.skipif(sys.platform != "linux", reason="of ELF files")
def test_a_library_has_no_path_of_the_machine_that_built_it_and_its_tables_are_read_only():
    for file in (Path(_calls.__file__), *(ahead.FOLDER / level["file"] for level in LEVELS.values())):
        content = file.read_bytes()
        assert not any(part in content for part in (b"pip-build-env", b"site-packages", b".debug_info", b".symtab"))
        dynamic = subprocess.run(["readelf", "-dlW", file], capture_output=True, text=True, check=True).stdout
        assert "RUNPATH" not in dynamic
        assert "RPATH" not in dynamic
        assert "GNU_RELRO" in dynamic
        assert "BIND_NOW" in dynamic


def test_the_notice_of_what_is_compiled_in_comes_along():
    (notice,) = (file for file in files("ulna") or () if file.name == "LICENSE-NUMBA")
    assert "Anaconda" in notice.read_text()
