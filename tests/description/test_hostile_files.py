"""Hostile files of each format: each is refused by a named error, in 1 GB of address space and 5 s of the processor."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from hostile_files import FILES, MB, MEMORY, SECONDS
from ulna.errors import MAX_CITED

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs limits of address space, and copies"),
]
PROGRAM = Path(__file__).parents[1] / "hostile_files.py"
_MAX_LENGTH = 3 * MAX_CITED  # of a message: what is refused, its file, and what to do


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """What came of reading each file, by its name: of one process, which copies itself for each file."""
    command = [sys.executable, str(PROGRAM), str(tmp_path_factory.mktemp("hostile"))]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    first, *lines = map(json.loads, done.stdout.splitlines())
    assert first["address space"] < 0.95 * MEMORY, "what is imported leaves no room"
    return {line["file"]: line for line in lines}


@pytest.mark.parametrize("name", FILES)
def test_a_hostile_file_is_refused_by_a_named_error(name, outcomes):
    one = outcomes[name]
    assert one["bytes"] <= 1.2 * MB
    assert one["named"], f"{one['error']}: {one['words'][:300]}"
    assert one["length"] <= _MAX_LENGTH, one["words"][:300]
    assert one["seconds"] <= SECONDS
