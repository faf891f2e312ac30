"""The first line of a module says what it does, or names the command that it is; who imports it is not repeated there."""

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "src" / "ulna"
MODULES = sorted(path.relative_to(SOURCES).as_posix() for path in SOURCES.rglob("*.py"))


@pytest.mark.parametrize("module", MODULES)
def test_the_first_line_of_a_module_is_a_sentence_about_what_it_does(module):
    docstring = ast.get_docstring(ast.parse((SOURCES / module).read_text(encoding="utf-8"))) or ""
    first = docstring.split("\n")[0]
    assert first.endswith((".", ":")), first
    assert "Used by" not in docstring
