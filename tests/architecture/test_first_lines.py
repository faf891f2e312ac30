"""The first line of a module says what it does, or names the command that it is; who imports it is not repeated there."""

import ast
from pathlib import Path

SOURCES = Path(__file__).parents[2] / "src" / "ulna"


def is_told(file):
    """Whether its docstring begins with a sentence, and does not list who imports it."""
    docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return docstring.split("\n")[0].endswith((".", ":")) and "Used by" not in docstring


def test_the_first_line_of_a_module_is_a_sentence_about_what_it_does():
    files = sorted(SOURCES.rglob("*.py"))
    assert len(files) > 300
    assert [file.relative_to(SOURCES).as_posix() for file in files if not is_told(file)] == []
