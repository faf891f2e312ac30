"""Lists the pages of the documentation, and the code blocks in them."""

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


class Block(NamedTuple):
    """A fenced block: its language, its text, and, behind Python that prints, what it prints (None: it is not told)."""

    language: str
    text: str
    printed: str | None = None


@cache  # the tests are chosen by them, in every process
def blocks(path):
    """The fenced blocks of a page in their order; ``text`` directly behind ``python`` is what that prints."""
    found, at, gap = [], None, []
    for line in path.read_text("utf-8").splitlines(keepends=True):
        if line.startswith("```") and at is None:
            at, language, text = line, line[3:].rstrip("\n"), []
        elif line.startswith("```"):
            at = None
            if language == "text" and not "".join(gap).strip() and found and found[-1].language == "python":
                found[-1] = found[-1]._replace(printed="".join(text))
            else:
                found.append(Block(language, "".join(text)))
            gap = []
        else:
            (gap if at is None else text).append(line)
    return found


def commands(path):
    """The lines that start with ``ulna`` in a page's shell blocks, without their comments."""
    lines = [line for block in blocks(path) if block.language == "sh" for line in block.text.splitlines()]
    return [re.sub(r"\s#.*", "", line).strip() for line in lines if line.startswith("ulna ")]
