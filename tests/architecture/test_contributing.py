"""The files that CONTRIBUTING names are there."""

import re
from pathlib import Path

from doc_pages import ROOT

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_a_file_that_is_named_is_there():
    paths = [path for folder in ("src", "tests", "docs") for path in (ROOT / folder).rglob("*.*")]
    files = {f"/{path.relative_to(ROOT).as_posix()}" for path in paths}
    named = {name for name in re.findall(r"`([\w/]+\.(?:py|md))`", TEXT) if not re.search(r"NAME|NN_", name)}
    assert len(named) > 15
    assert sorted(name for name in named if not any(file.endswith(f"/{name}") for file in files)) == []


def test_a_folder_that_is_named_is_there():
    named = set(re.findall(r"\| `(\w+)/`", TEXT)) - {"demo"}  # a guest, which may be absent
    assert len(named) > 10
    assert sorted(name for name in named if not Path(ROOT, "src", "ulna", name).is_dir()) == []
