"""Writes a result's table for a notebook: a sentence, rows of text, and notes, as self-contained HTML."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import islice

MAX_ROWS = 40
_NUMBERS = "text-align:right;font-variant-numeric:tabular-nums"
_NAME = "text-align:left"


class OneLine:
    """A result whose ``repr`` is its class and its sentence, ``str(result)``. Dataclasses inherit it with ``repr=False``."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self}>"


def table(sentence: str, headers: Sequence[str] = (), rows: Iterable[Sequence[object]] = (), notes: Iterable[str] = ()) -> str:
    """Write a sentence, a table of at most ``MAX_ROWS`` rows below it, and lines of notes, as HTML.

    Args:
        sentence: A summary of the result.
        headers: The headers of the columns.
        rows: A name, and the other cells of each row; numbers are written with at most five digits.
        notes: Lines below the table.
    """
    every = iter(rows)
    body = "".join(_row(row) for row in islice(every, MAX_ROWS))
    n_more = sum(1 for _ in every)
    lines = ([f"and {n_more} more"] if n_more else []) + list(notes)
    head = "".join(f'<th scope="col">{escape(header)}</th>' for header in headers)
    shown = f'<table style="{_NUMBERS}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>' if body else ""
    return f"<div>{escape(sentence)}{shown}{''.join(f'<div>{escape(line)}</div>' for line in lines)}</div>"


def _row(cells: Sequence[object]) -> str:
    name, *others = map(_text, cells)
    return f'<tr><th scope="row" style="{_NAME}">{name}</th>{"".join(f"<td>{each}</td>" for each in others)}</tr>'


def _text(cell: object) -> str:
    """Format a cell, escaped: a number with five digits, an infinite one as nothing."""
    if isinstance(cell, float):
        return "" if cell in {float("inf"), float("-inf")} else f"{cell + 0.0:.5g}"
    return escape(str(cell))
