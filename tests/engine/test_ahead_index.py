"""The index of a wheel's machine code: whatever it holds, it is an error of Ulna's that names the file."""

import copy
import json

import pytest

from ulna import FileError
from ulna.engine import ahead

GOOD = {
    "package": "ulna",
    "levels": {"x86-64-v2": {"needs": 2, "file": "v2.so", "size": 0, "sha256": "0"}},
    "entries": {"a.b": {"overloads": [{"symbol": "s", "signature": "f"}], "result": "b", "releases_lock": True}},
}
PLACES = [
    [],
    *([name] for name in GOOD),
    ["levels", "x86-64-v2"],
    *(["levels", "x86-64-v2", name] for name in ("needs", "file", "size", "sha256")),
    ["entries", "a.b"],
    *(["entries", "a.b", name] for name in ("overloads", "result", "releases_lock")),
    ["entries", "a.b", "overloads", 0],
    *(["entries", "a.b", "overloads", 0, name] for name in ("symbol", "signature")),
]


def changed(place: list, value: object) -> object:
    index = copy.deepcopy(GOOD)
    if not place:
        return value
    inner = index
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    return index


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("value", [None, 1.5, [None], {"a": None}], ids=str)
def test_an_index_of_another_form_is_refused_with_its_name(tmp_path, monkeypatch, place, value):
    monkeypatch.setattr(ahead, "extension", lambda: type("Calls", (), {"x86_level": staticmethod(lambda: 9)}))
    (tmp_path / ahead.INDEX).write_text(json.dumps(changed(place, value)))
    with pytest.raises(FileError, match=r"index\.json: the machine code of this wheel cannot be loaded .*install it again"):
        ahead.load_library(tmp_path, "")


def test_an_index_that_is_nested_deeply_is_refused(tmp_path):
    (tmp_path / ahead.INDEX).write_text("[" * 100_000)
    with pytest.raises(FileError, match="install it again"):
        ahead.load_library(tmp_path, "")
