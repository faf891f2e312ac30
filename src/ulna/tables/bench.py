"""``ulna bench`` for people."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from ulna.tables.writing import make_table


def bench_view(data) -> Iterator[RenderableType]:
    """The machine, and a table for each list of rows: its keys are the columns."""
    yield Text(", ".join(f"{key.replace('_', ' ')} {value}" for key, value in data["machine"].items()))
    for title, rows in data.items():
        if title != "machine" and rows:
            yield Text(title.replace("_", " "), "bold")
            yield _measured(rows)


def _measured(rows) -> Table:
    names = [key for key, value in rows[0].items() if isinstance(value, str)]
    table = make_table([_header(key) for key in names], [_header(key) for key in rows[0] if key not in names], [])
    for row in rows:
        table.add_row(*(row[key] for key in names), *(_figure(value) for key, value in row.items() if key not in names))
    return table


def _header(key: str) -> str:
    return key.replace("_", "\n")


def _figure(value: float) -> str:
    """Four digits, or all of a whole number."""
    return f"{value:,}" if isinstance(value, int) else f"{value:,.0f}" if value >= 1000 else f"{value:.4g}"
