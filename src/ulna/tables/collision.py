"""``ulna check`` for people."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from ulna.tables.writing import make_table, number, title


def report_view(data) -> Iterator[RenderableType]:
    """The verdict, and the pairs, deepest first."""
    yield title(data, "collision check")
    if data["pairs"]:
        table = make_table(["robot", "link", "world"], ["depth [mm]", "normal x", "y", "z"], [])
        for pair in data["pairs"]:
            depth = f"{-1000 * pair['signed_distance'] + 0.0:.3f}"
            table.add_row(pair["name_a"], pair["link"], pair["name_b"], depth, *(number(n, 3) for n in pair["normal"]))
        yield table
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")
