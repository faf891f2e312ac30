"""Runs the lessons from the first cell to the last; their exercises are unsolved, and can be solved."""

import json
import runpy
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt

DOCS = Path(__file__).parents[1] / "docs"
LESSONS = sorted((DOCS / "lessons").glob("*.ipynb"))
pytestmark = pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
mpl.use("agg")
EXERCISES = runpy.run_path(str(DOCS / "site" / "exercises.py"))


def notebook_at(path):
    return json.loads(path.read_text(encoding="utf-8"))


def run(notebook):
    """Run the code of a notebook in one namespace, without a screen."""
    names = {"__name__": "__main__"}
    code = [(cell["id"], "".join(cell["source"])) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    try:
        with np.printoptions():  # lessons set their own, for the whole process
            for cell, text in code:
                exec(compile(text, cell, "exec"), names)  # noqa: S102 - our own lessons
    finally:
        plt.close("all")


def tagged(notebook, tag):
    return [cell for cell in notebook["cells"] if tag in cell["metadata"].get("tags", ())]


@pytest.mark.slow
@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_lesson_runs_with_its_solutions(path):
    run(EXERCISES["with_solutions"](notebook_at(path)))


@pytest.mark.slow
@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_an_exercise_that_is_not_done_is_not_passed(path):
    notebook = notebook_at(path)
    assert len(tagged(notebook, "exercise")) == len(tagged(notebook, "check")) == 2
    solved = EXERCISES["with_solutions"](notebook)
    for left_out in tagged(notebook, "exercise"):
        cells = [cell for cell in solved["cells"] if cell["id"] != f"{left_out['id']}-solved"]
        with pytest.raises(NotImplementedError, match="replace this line by your own"):
            run({**solved, "cells": cells})


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_lesson_is_stored_without_outputs(path):
    code = [cell for cell in notebook_at(path)["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def test_there_are_seven_lessons():
    assert len(LESSONS) == 7
