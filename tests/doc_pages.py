"""The pages for readers, and the blocks of code in them."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


class Block(NamedTuple):
    """A fenced block: its language, its text, and, behind Python that prints, what it prints (None: it is not told)."""

    language: str
    text: str
    printed: str | None = None


def blocks(path):
    """The fenced blocks of a page in their order; ``text`` directly behind ``python`` is what that prints."""
    found = []
    for gap, language, text in re.findall(r"(?m)([\s\S]*?)^```([^\n]*)\n([\s\S]*?)^```[^\n]*\n", path.read_text("utf-8")):
        if language == "text" and not gap.strip() and found and found[-1].language == "python":
            found[-1] = found[-1]._replace(printed=text)
        else:
            found.append(Block(language, text))
    return found


def commands(path):
    """The lines that start with ``ulna`` in a page's shell blocks, without their comments."""
    lines = [line for block in blocks(path) if block.language == "sh" for line in block.text.splitlines()]
    return [re.sub(r"\s#.*", "", line).strip() for line in lines if line.startswith("ulna ")]
