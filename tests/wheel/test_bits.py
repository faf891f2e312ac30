"""Machine code compiled ahead gives the bits of machine code compiled now for the same level of CPU, entry by entry.

``make test-wheel`` has Numba's answers written by ``every_entry`` first, in the environment of the other tests, to ULNA_BITS.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ulna.engine.ahead import FOLDER, INDEX, level

PROGRAM = Path(__file__).with_name("every_entry.py")


@pytest.fixture(scope="module")
def ahead(tmp_path_factory):
    file = tmp_path_factory.mktemp("bits") / "ahead.json"
    environment = {**os.environ, "ULNA_CPU": level(), "PYTHONHASHSEED": "0"}
    subprocess.run([sys.executable, str(PROGRAM), str(file)], check=True, env=environment)
    return json.loads(file.read_text())


def test_every_entry_is_called_for_every_signature(ahead):
    entries = json.loads((FOLDER / INDEX).read_text())["entries"]
    for name, entry in entries.items():
        assert sum(key == name or key.startswith(f"{name} (") for key in ahead) == len(entry["overloads"]), name


def test_ahead_and_now_give_the_same_bits(ahead):
    now = json.loads(Path(os.environ["ULNA_BITS"], f"{level()}.json").read_text())
    assert now == ahead
