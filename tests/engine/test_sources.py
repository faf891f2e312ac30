"""The key of machine code covers the files of an entry and no others. The truth: the modules that Python loads for it."""

import ast
import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import ulna
from matrix import matrix
from ulna.engine import sources

PACKAGE = Path(ulna.__file__).parent
MODULES = sorted(
    str(path.relative_to(PACKAGE).with_suffix(""))
    for path in PACKAGE.rglob("entries/*.py")
    if path.stem not in ("__init__", "batch", "lane_state", "search_records")
)
FORWARD = "kinematics/entries/forward"
KERNELS = sorted(str(path.relative_to(PACKAGE)) for path in (PACKAGE / "kernels").rglob("*.py") if path.stem != "__init__")
CHOSEN = (
    "spatial/se3.py",
    "chain/sliding_arm.py",
    "planning/space.py",
    "render/illumination.py",
    "layout.py",
)  # of many, and of few
LOADED = """
import importlib, json, sys
import ulna.engine.decorators
found = {}
def is_ours(name):
    return name.startswith("ulna.kernels.") or ".entries." in name
for module in sys.argv[1:]:
    for name in list(sys.modules):
        if is_ours(name):
            del sys.modules[name]
    importlib.import_module("ulna." + module.replace("/", "."))
    found[module] = [each.__file__ for name, each in sys.modules.items() if is_ours(name)]
print(json.dumps(found))
"""


@cache
def loaded_by():
    """For each module of entries the files of kernels and entries that Python loads for it."""
    found = subprocess.run([sys.executable, "-c", LOADED, *MODULES], capture_output=True, text=True, check=True).stdout
    return {module: {str(Path(file).relative_to(PACKAGE)) for file in files} for module, files in json.loads(found).items()}


@pytest.fixture
def forgetful():
    """Files are read once in a process; here they change."""
    cached = (sources.text_of, sources.sources_hash, sources._used_by, sources._place, sources._name)

    def forget():
        for function in cached:
            function.cache_clear()

    forget()
    yield forget
    forget()


@pytest.fixture
def clone(tmp_path):
    return Path(shutil.copytree(PACKAGE, tmp_path / "ulna", ignore=shutil.ignore_patterns("__pycache__", "*.urdf", "*.dae")))


def keys(package):
    return {module: sources.sources_hash(str(package / f"{module}.py")) for module in MODULES}


def imported_by(text):
    """The imports of a file as Python sees them: of modules, and of names of modules."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            yield from (("." * node.level + (node.module or ""), alias.name) for alias in node.names)


def test_every_import_that_python_sees_is_found_in_the_text():
    files = [path for pattern in ("engine/**/*.py", "kernels/**/*.py", "**/entries/*.py") for path in PACKAGE.glob(pattern)]
    assert len(files) > 100
    missed = []
    for text in (path.read_text() for path in files):
        found = {(module, name) for module, names in sources.imports_of(text) for name in [None, *names]}
        missed += set(imported_by(text)) - found
    assert missed == []


@pytest.mark.parametrize(
    "text",
    [
        "from ulna.kernels import (  # which (of many)\n    layout,  # plain\n    other,\n)",
        "from ulna.kernels \\\n    import layout",
        "if True:\n    from ulna.kernels import layout as table",
        "import ulna.kernels.layout as table, math",
        "import math, ulna.kernels.layout",
        "from ulna.kernels.layout import *",
        "from .layout import LARGEST",
        "from . import layout",
        "from ..kernels import layout",
    ],
)
def test_however_an_import_is_written_its_file_is_found(text, clone, forgetful):
    (clone / "kernels" / "new.py").write_text(text)
    assert str(clone / "kernels" / "layout.py") in sources.files_used(str(clone / "kernels" / "new.py"))


@pytest.mark.parametrize("module", MODULES)
def test_what_python_loads_for_entries_is_what_their_key_covers(module):
    covered = {str(Path(file).relative_to(PACKAGE)) for file in sources.files_used(str(PACKAGE / f"{module}.py"))}
    packages = {file for file in loaded_by()[module] if Path(file).name == "__init__.py"}  # they lie on the way
    assert loaded_by()[module] - packages <= covered
    assert {file for file in covered if not file.startswith("engine")} <= loaded_by()[module]


def test_a_clone_has_the_same_keys(clone):
    assert keys(clone) == keys(PACKAGE)


@pytest.mark.parametrize("kernel", matrix(KERNELS, [f"kernels/{name}" for name in CHOSEN]))
def test_a_change_in_a_kernel_changes_the_keys_of_those_that_use_it_and_of_no_others(kernel, clone, forgetful):
    before = keys(clone)
    (clone / kernel).write_text((clone / kernel).read_text() + "# changed\n")
    forgetful()
    after = keys(clone)
    assert {module for module in MODULES if after[module] != before[module]} == {
        module for module in MODULES if kernel in loaded_by()[module]
    }


def test_a_change_in_what_makes_machine_code_changes_every_key(clone, forgetful):
    for name in ("lanes", "lane_types", "lane_lowering", "numba_private", "signatures", "decorators", "cache"):
        before = keys(clone)
        (clone / "engine" / f"{name}.py").write_text((clone / "engine" / f"{name}.py").read_text() + "# changed\n")
        forgetful()
        after = keys(clone)
        assert all(after[module] != before[module] for module in MODULES), name


@pytest.mark.parametrize("name", ["threads", "warmup", "entries", "processors"])
def test_a_change_in_what_only_calls_machine_code_changes_no_key(name, clone, forgetful):
    before = keys(clone)
    (clone / "engine" / f"{name}.py").write_text("# changed\n")
    forgetful()
    assert keys(clone) == before


def test_a_renamed_kernel_changes_the_key(clone, forgetful):
    before = keys(clone)[FORWARD]
    (clone / "kernels" / "spatial" / "so_three.py").write_text("")
    file = clone / f"{FORWARD}.py"
    file.write_text(file.read_text() + "from ulna.kernels.spatial import so_three\n")
    forgetful()
    one = keys(clone)[FORWARD]
    (clone / "kernels" / "spatial" / "so_three.py").rename(clone / "kernels" / "spatial" / "so_drei.py")
    file.write_text(file.read_text().replace("so_three", "so_drei"))
    forgetful()
    assert len({before, one, keys(clone)[FORWARD]}) == 3


def test_the_entries_of_another_package_follow_its_own_files_and_ulnas(tmp_path, forgetful):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "drivers.py").write_text("from arm.formulas import f\nfrom ulna.kernels.spatial.se3 import compose\n")
    (tmp_path / "arm" / "formulas.py").write_text("import numpy\nimport beside\n")
    (tmp_path / "arm" / "beside.py").write_text("")
    used = {Path(file).name for file in sources.files_used(str(tmp_path / "arm" / "drivers.py"))}
    assert {"drivers.py", "formulas.py", "beside.py", "se3.py", "decorators.py"} <= used
    assert not any("numpy" in file for file in sources.files_used(str(tmp_path / "arm" / "drivers.py")))


def test_a_folder_above_a_clone_may_have_the_packages_name(tmp_path, forgetful):
    home = tmp_path / "ulna"
    shutil.copytree(PACKAGE, home / "src" / "ulna", ignore=shutil.ignore_patterns("__pycache__"))
    (home / "benchmarks").mkdir()
    (home / "benchmarks" / "mine.py").write_text("from ulna.kernels.spatial.se3 import compose\n")
    assert keys(home / "src" / "ulna") == keys(PACKAGE)
    assert str(PACKAGE / "kernels" / "spatial" / "se3.py") in sources.files_used(str(home / "benchmarks" / "mine.py"))
