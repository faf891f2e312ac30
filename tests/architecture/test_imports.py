"""Public names are imported when they are first used, and a first pose imports nothing that it does not need."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import ulna

UNNEEDED = {"asyncio", "concurrent", "email", "http", "importlib.metadata", "rich", "ssl", "subprocess", "tempfile", "typer",
            "ulna.gpu", "ulna.inspection", "ulna.reachability", "ulna.viewer", "urllib.request", "zipfile"}  # fmt: skip


def loaded_by(code):
    """The modules that are loaded after some lines of Python in a new process."""
    program = f"{code}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_the_names_that_the_types_have_are_the_names_at_run_time():
    tree = ast.parse(Path(ulna.__file__).read_text(encoding="utf-8"))
    (for_types,) = (node for node in tree.body if isinstance(node, ast.If))
    named = {node.module: tuple(alias.name for alias in node.names) for node in for_types.body}
    assert named == ulna._HOMES
    assert sorted(name for names in named.values() for name in names) == sorted(ulna.__all__)


def test_every_public_name_is_what_its_module_has():
    for module, names in ulna._HOMES.items():
        home = __import__(module, fromlist=names)
        for name in names:
            assert getattr(ulna, name) is getattr(home, name)
            assert name in dir(ulna)


def test_a_name_that_there_is_not_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'ulna' has no attribute 'robbot'"):
        _ = ulna.robbot
    with pytest.raises(ImportError, match="robbot"):
        from ulna import robbot  # noqa: F401
    assert ulna.load("panda")
    assert ulna.kinematics.tree.build_tree  # which a robot has imported


def test_importing_ulna_alone_imports_none_of_its_modules():
    loaded = loaded_by("import ulna")
    assert "numpy" not in loaded
    assert {name for name in loaded if name.startswith("ulna")} == {"ulna"}
    assert "ulna.viewer" in loaded_by("from ulna import *")


def test_loading_a_robot_imports_nothing_that_it_does_not_need():
    loaded = loaded_by("import ulna\nulna.load('panda')")
    assert "ulna.robot" in loaded
    assert not loaded & UNNEEDED
