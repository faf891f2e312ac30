import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs_and_its_assertions_hold(path):
    runpy.run_path(str(path), run_name="__main__")


def test_there_are_examples():
    assert len(EXAMPLES) >= 4


def test_the_ten_lines_of_the_readme_run_and_print_what_they_say(capsys):
    code = (ROOT / "README.md").read_text().split("```python\n")[1].split("```")[0]
    exec(code, {})  # noqa: S102 - our own README
    promised = [line.split("# ")[1].strip() for line in code.splitlines() if line.startswith("print")]
    assert capsys.readouterr().out.splitlines() == promised
