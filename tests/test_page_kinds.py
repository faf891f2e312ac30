"""Checks that each page of docs/ states its kind, that how-tos are short, and that old anchors still exist."""

import re
from collections import Counter
from pathlib import Path

import pytest

from doc_pages import ROOT

DOCS = ROOT / "docs"
KINDS = ("Tutorial", "How-to", "Explanation", "Reference", "Measurements")
MAX_WORDS = 900  # of prose, on a how-to
WITHOUT_KIND = {"index.md", "changelog.md"}
PAGES = sorted(page.name for page in DOCS.glob("*.md") if page.name not in WITHOUT_KIND)
ANCHORS = (Path(__file__).parent / "anchors.txt").read_text(encoding="utf-8").split()
CAPTIONS = {"Getting started": "Tutorial", "Troubleshooting": "How-to"}  # the other captions begin with the kind itself


def prose(text: str) -> str:
    """The running text of a page: without fenced blocks, tables, headings, targets and directives."""
    text = re.sub(r"(?ms)^(```+|:::+).*?^\1\s*$", "", text)
    lines = [line for line in text.splitlines() if not re.match(r"\s*\||#|\(\S+\)=\s*$|<a id=", line)]
    return "\n".join(lines)


def headings(text: str) -> list[str]:
    """The headings of a page in their order, without their marks."""
    return re.findall(r"(?m)^#{1,4} (.*)$", re.sub(r"(?ms)^(```+).*?^\1\s*$", "", text))


def slug(heading: str) -> str:
    """The address of a heading within its page, as MyST and GitHub form it."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower().strip()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def anchors(text: str) -> set[str]:
    """Every address within a page: of its headings, targets and HTML anchors."""
    in_html = re.findall(r'(?m)^<a id="(\S+)"></a>\s*$', text)
    return {slug(heading) for heading in headings(text)} | set(targets(text)) | set(in_html)


def targets(text: str) -> list[str]:
    """The targets of a page."""
    return re.findall(r"(?m)^\((\S+)\)=\s*$", text)


def kind(text: str) -> str | None:
    """The kind of a page, from the first line below its title."""
    found = re.match(r"(?:\(\S+\)=\n+)*# .+\n+\*([\w-]+)\*\n", text)
    return found[1] if found and found[1] in KINDS else None


def groups() -> dict[str, str]:
    """The caption of the side bar below which each page stands."""
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    trees = re.findall(r"(?ms)^```\{toctree\}\n(.*?)\n\n(.*?)\n```", index)
    return {f"{page}.md": re.search(r':caption: "?([^"\n]*)', options)[1] for options, pages in trees for page in pages.split()}


def faults(name: str) -> list[str]:
    """The reasons why a page is not done."""
    text = (DOCS / name).read_text(encoding="utf-8")
    its_kind, caption, words = kind(text), groups().get(name), len(prose(text).split())
    lost = [anchor for page, anchor in (line.split("#") for line in ANCHORS) if page == name and anchor not in anchors(text)]
    found = [f"#{anchor} is gone: write ({anchor})= before the paragraph that leads on" for anchor in lost]
    if its_kind is None:
        found.append(f"below the title, a line of its own states the kind: one of {', '.join(f'*{kind}*' for kind in KINDS)}")
    if its_kind == "How-to" and words > MAX_WORDS:
        found.append(f"{words} words of prose, more than {MAX_WORDS}")
    if caption is None:
        found.append("in no toctree of docs/index.md")
    elif its_kind and CAPTIONS.get(caption, caption.split(":")[0]) != its_kind:
        found.append(f"a page of kind {its_kind} stands below {caption!r} in docs/index.md")
    return found


@pytest.mark.parametrize("name", PAGES)
def test_a_page_has_a_kind_and_keeps_its_addresses(name):
    assert faults(name) == []


def test_a_target_is_on_one_page():
    """Sphinx takes a target for a label of the whole site. A second page with the same address has ``<a id="..."></a>``."""
    texts = [(DOCS / name).read_text(encoding="utf-8") for name in PAGES]
    counts = Counter(target for text in texts for target in targets(text))
    assert [target for target, count in counts.items() if count > 1] == []


def test_words_in_code_and_tables_are_not_counted():
    page = "(old)=\n# A\n\n*How-to*\n\nThree words here.\n\n```python\none = 1\n```\n\n| a | b |\n|---|---|\n\n## `load` it: x\n"
    assert prose(page).split() == ["*How-to*", "Three", "words", "here."]
    assert anchors(page) == {"old", "a", "load-it-x"}
    assert kind(page) == "How-to"
    assert kind("# A\n\nHow-to\n") is None
