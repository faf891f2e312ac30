"""The figures of the pages of measurements are those of the run that they cite."""

import json
import re
import shutil
from pathlib import Path

import pytest
from benchmarks import summary

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").glob("performance*.md"))
RESULTS = sorted((ROOT / "benchmarks" / "results").glob("*.json"))


@pytest.fixture(scope="module")
def blocks():
    if not RESULTS:
        pytest.skip("the results of the benchmarks are not part of this copy")
    return summary.tables(json.loads(RESULTS[-1].read_text(encoding="utf-8")), RESULTS[-1].with_suffix(".md").name)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_has_the_figures_of_the_last_run(page, blocks, tmp_path):
    copy = Path(shutil.copy(page, tmp_path))
    summary.write(copy, blocks)
    assert copy.read_text(encoding="utf-8") == page.read_text(encoding="utf-8"), "run python -m benchmarks.summary RESULT.json"


def test_every_block_of_figures_is_on_one_page(blocks):
    marked = [name for page in PAGES for name in re.findall(r"<!-- figures: (.+?) -->", page.read_text(encoding="utf-8"))]
    assert sorted(marked) == sorted(blocks)


def test_a_block_that_the_run_lacks_keeps_its_figures(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("<!-- figures: old -->\n\n1\n\n<!-- end -->\n<!-- figures: new -->\n\n<!-- end -->\n", encoding="utf-8")
    summary.write(page, {"new": "2"})
    assert page.read_text(encoding="utf-8") == (
        "<!-- figures: old -->\n\n1\n\n<!-- end -->\n<!-- figures: new -->\n\n2\n\n<!-- end -->\n"
    )
