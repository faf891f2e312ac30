"""Checks the English of pages, docstrings and lessons. `make lint` runs it; `python tests/english.py FILE...` checks some files.

The rules are few, and each has its reason:

- A sentence has at most 25 words, and a docstring's first one at most 20. Longer ones have to be read twice.
- A docstring begins with a noun or a verb. A pronoun or a preposition there names nothing.
- ``VOCABULARY`` lists phrases that no reader can search for, each with the field's own.
- proselint knows the faults of English in general. Its rules of typography, dates and currencies do not fit a page with code.

Spelling, American throughout, is codespell's (pyproject.toml).
"""

import ast
import json
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt
from proselint.checks import __register__
from proselint.config import Config
from proselint.registry import CheckRegistry
from proselint.tools import LintFile

ROOT = Path(__file__).parents[1]
PAGES = ("README.md", "CONTRIBUTING.md", "hw2/README.md", "docs/*.md", "docs/lessons/*.ipynb")
CHECKED = (*PAGES, "src/ulna/**/*.py", "hw2/*.py", "examples/*.py")
MAX_WORDS, MAX_FIRST = 25, 20
NOT_FIRST = {"what", "that", "those", "these", "of", "how", "where", "which", "whose", "as", "by", "and", "it", "they"}
VOCABULARY = {
    r"\bsays? so\b": "name what is said",
    r"\b(is|are|was|were|be) had\b": "is available, is reached",
    r"\banew\b": "again",
    r"\bat last\b": "finally, in the end",
    r"\bin the mean\b": "on average",
    r"\bgo(es)? over into\b": "switches to",
    r"\b(gives?|gave) (it|them) times\b": "time parameterization",
    r"\bwhat is missed\b": "the error",
    r"\bwhat is missing\b": "the error, the rest",
    r"\bleads? on\b": "continues",
    r"\b(is|are) of no account\b": "is ignored",
    r"\bone of which\b": "name the thing",
    r"\bwhat is beyond\b": "name the thing",
    r"\bwas not (sought|looked for)\b": "leave it out",
    r"\bas the code was\b": "leave it out",
    r"\bsuch (a )?ways?\b": "path",
}
PROSELINT = (
    "archaism",
    "cliches",
    "lexical_illusions",
    "malapropisms",
    "mondegreens",
    "nonwords",
    "redundancy",
    "spelling",
)


class Piece(NamedTuple):
    """Prose of a file: paragraphs of one docstring, page or cell.

    Attributes:
        line: The number of its first line.
        paragraphs: Its paragraphs, without code and markup.
        is_docstring: Whether its first sentence is a summary.
    """

    line: int
    paragraphs: list[str]
    is_docstring: bool


def paragraphs_of(markdown: str) -> Iterator[tuple[int, str]]:
    """The paragraphs of a Markdown text with their first lines, code and links' targets left out, tables too."""
    in_table = False
    markdown = re.sub(r"\A---\n.*?\n---\n", lambda m: "\n" * m[0].count("\n"), markdown, flags=re.DOTALL)
    for token in MarkdownIt("commonmark").enable("table").parse(markdown):
        in_table = token.type == "table_open" or (in_table and token.type != "table_close")
        if token.type == "inline" and not in_table and token.map is not None:
            parts = token.children or []
            shown = {"code_inline": "X", "softbreak": " "}
            text = "".join(part.content if part.type == "text" else shown.get(part.type, "") for part in parts)
            if not re.fullmatch(r"\s*(\(\S+\)=|:::.*)?\s*", text):
                yield token.map[0] + 1, text


def docstrings_of(source: str) -> Iterator[Piece]:
    """The docstrings of a module, of its classes and of its functions."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (text := ast.get_docstring(node)):
            text = re.sub(r"(?m)^\s*>>> .*\n(\s*\S.*\n?)*", "\n", text + "\n")  # examples
            text = re.sub(r"(?m)(?<=\n\n)( {4,}\S.*\n)+(?=\n|\Z)", "", text)  # formulas, and blocks of code
            text = re.sub(r"(?m)^=+( =+)+\n(.*\n)*?=+( =+)+$", "", text)  # tables
            text = re.sub(r"``[^`]*``|`[^`]*`", "X", text)
            parts = re.split(r"\n\s*\n|\n(?=\s*(?:[-*] |\d+\. |\w[\w, *]*: ))", text)
            yield Piece(node.body[0].lineno, [" ".join(part.split()) for part in parts if part.strip()], is_docstring=True)


def pieces_of(file: Path) -> Iterator[Piece]:
    """The prose of a file."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        yield from docstrings_of(text)
    elif file.suffix == ".ipynb":
        for cell in json.loads(text)["cells"]:
            if cell["cell_type"] == "markdown":
                yield Piece(1, [part for _, part in paragraphs_of("".join(cell["source"]))], is_docstring=False)
    else:
        yield from (Piece(line, [part], is_docstring=False) for line, part in paragraphs_of(text))


def sentences_of(paragraph: str) -> list[str]:
    """The sentences of a paragraph: a colon and a semicolon end one too, and what is in parentheses is one of its own."""
    text = re.sub(r"\$\$.*?\$\$|\$[^$]*\$|“[^”]*”|\"[^\"]*\"", "X", paragraph)  # formulas, and words of others
    inner = re.findall(r"\(([^()]*)\)", text)
    text = re.sub(r"\s*\([^()]*\)", "", text)
    return [part for whole in (text, *inner) for part in re.split(r"(?<=[.:;!?])\s+", whole) if part.strip()]


def own_faults(piece: Piece) -> Iterator[str]:
    """The sentences of a piece that are too long, that begin with nothing, or that use a phrase of ``VOCABULARY``."""
    for number, paragraph in enumerate(piece.paragraphs):
        for place, sentence in enumerate(sentences_of(paragraph)):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            is_summary = piece.is_docstring and number == place == 0
            if len(words) > (MAX_FIRST if is_summary else MAX_WORDS):
                yield f"{len(words)} words: {sentence}"
            if is_summary and words and words[0].lower() in NOT_FIRST:
                yield f"begins with {words[0]!r}: {sentence}"
        for phrase, better in VOCABULARY.items():
            for match in re.finditer(phrase, paragraph, re.IGNORECASE):
                yield f"{match[0]!r}: {better}: {paragraph[max(match.start() - 40, 0) : match.end() + 40]}"


def general_faults(piece: Piece, config: Config) -> Iterator[str]:
    """The faults that proselint finds in a piece."""
    text = "\n\n".join(piece.paragraphs) + "\n"
    for result in LintFile("prose", text).lint(config):
        check, message = result.check_result.check_path, result.check_result.message
        if check != "lexical_illusions" or re.search(r"'[a-z]{2,}( [a-z]{2,})+'", message):  # not symbols: "J J^T", "0 0"
            yield f"{message} ({check})"


def faults_of(file: Path, config: Config) -> Iterator[str]:
    """The faults of a file, each with its place."""
    name = file.relative_to(ROOT).as_posix()
    for piece in pieces_of(file):
        yield from (f"{name}:{piece.line}: {fault}" for fault in (*own_faults(piece), *general_faults(piece, config)))


def main(names: Iterable[str]) -> int:
    """Print the faults of some files, or of all."""
    files = [Path(name).resolve() for name in names] or sorted(file for pattern in CHECKED for file in ROOT.glob(pattern))
    CheckRegistry().register_many(__register__)
    config = Config(max_errors=1000, checks=dict.fromkeys(PROSELINT, True))
    faults = [fault for file in files for fault in faults_of(file, config)]
    sys.stdout.write("".join(f"{fault}\n" for fault in faults) + f"English: {len(faults)} faults in {len(files)} files\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
