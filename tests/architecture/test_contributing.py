"""The files that CONTRIBUTING names are there."""

import re
from pathlib import Path

import pytest

from doc_pages import ROOT

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
FILES = [path.relative_to(ROOT).as_posix() for folder in ("src", "tests", "docs") for path in (ROOT / folder).rglob("*.*")]
NAMED = sorted({name for name in re.findall(r"`([\w/]+\.(?:py|md))`", TEXT) if not re.search(r"NAME|NN_", name)})


@pytest.mark.parametrize("name", NAMED)
def test_a_file_that_is_named_is_there(name):
    assert any(file == name or file.endswith(f"/{name}") for file in FILES)


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\| `(\w+)/`", TEXT)) - {"demo"}))  # a guest, which may be absent
def test_a_folder_that_is_named_is_there(name):
    assert Path(ROOT, "src", "ulna", name).is_dir()


def test_files_are_named():
    assert len(NAMED) > 15
