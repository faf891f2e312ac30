"""The first line of a module says what it does and who uses it, or names the command that it is."""

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "src" / "ulna"
MODULES = sorted(path.relative_to(SOURCES).as_posix() for path in SOURCES.rglob("*.py") if path.name != "__init__.py")


@pytest.mark.parametrize("module", MODULES)
def test_the_first_line_of_a_module_names_its_users(module):
    docstring = ast.get_docstring(ast.parse((SOURCES / module).read_text(encoding="utf-8"))) or ""
    first = docstring.split("\n")[0]
    assert "Used by " in first or first.startswith(f"``ulna {Path(module).stem}``: ")
