"""Solutions of the lessons' exercises, put where a reader of the site can unfold them.

A cell with the tag ``exercise`` defines one function with an empty body. In the notebook itself the student fills it in, and the
cell behind it checks. The solution is the function of the same name in ``docs/lessons/solutions.py``.
"""

import ast
import json
from pathlib import Path

_FOLDED = {"tags": ["hide-cell"], "mystnb": {"code_prompt_show": "Show a solution", "code_prompt_hide": "Hide the solution"}}
_SOLUTIONS = Path(__file__).parents[1] / "lessons" / "solutions.py"


def with_solutions(notebook):
    """The notebook with a cell behind each exercise that solves it; folded in on the site."""
    solved = []
    for cell in notebook["cells"]:
        solved.append(cell)
        if "exercise" in cell["metadata"].get("tags", ()):
            solution = _solution_of(exercise_name("".join(cell["source"])))
            solved.append({**cell, "id": f"{cell['id']}-solved", "source": solution, "metadata": _FOLDED})
    return {**notebook, "cells": solved}


def exercise_name(source):
    """The function that an exercise asks for: the only one that its cell defines."""
    (name,) = [part.name for part in ast.parse(source).body if isinstance(part, ast.FunctionDef)]
    return name


def _solution_of(name):
    text = _SOLUTIONS.read_text(encoding="utf-8")
    (found,) = [part for part in ast.parse(text).body if isinstance(part, ast.FunctionDef) and part.name == name]
    return ast.get_source_segment(text, found) + "\n"


def _read(app, docname, source):
    if docname.startswith("lessons/") and str(app.env.doc2path(docname)).endswith(".ipynb"):
        source[0] = json.dumps(with_solutions(json.loads(source[0])))


def setup(app):
    """Solve each lesson as it is read."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True}
