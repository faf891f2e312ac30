import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))
ELSEWHERE = {"16_learn_ik.py"}  # PyTorch is in an environment of its own: tests/learning/test_learned.py runs it


@pytest.mark.slow
@pytest.mark.parametrize("path", [path for path in EXAMPLES if path.name not in ELSEWHERE], ids=lambda path: path.stem)
def test_example_runs_and_its_assertions_hold(path):
    runpy.run_path(str(path), run_name="__main__")


def test_the_page_lists_every_example_and_marks_those_with_a_page():
    listed = dict(re.findall(r"(?m)^\| `(\d\d_\w+\.py)`( \*)? \|", (ROOT / "docs" / "examples.md").read_text()))
    assert list(listed) == [path.name for path in EXAMPLES]
    assert {name for name, mark in listed.items() if mark} == {path.name for path in EXAMPLES if "--view" in path.read_text()}


@pytest.mark.parametrize("call", [".plan(", ".plan_many(", ".follow(", ".trajectory(", ".improve(", "PointCloud("])
def test_an_example_shows_what_a_motion_is_made_with(call):
    assert any(call in path.read_text() for path in EXAMPLES)


def test_the_first_lines_of_the_readme_run_and_print_what_they_say(capsys):
    code = (ROOT / "README.md").read_text().split("```python\n")[1].split("```")[0]
    exec(code, {})  # noqa: S102 - our own README
    promised = [line.split("# ")[1].strip() for line in code.splitlines() if line.startswith("print")]
    assert capsys.readouterr().out.splitlines() == promised
