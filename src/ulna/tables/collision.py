"""``ulna check`` for people."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from ulna.tables.writing import make_table, number, title


def report_view(data) -> Iterator[RenderableType]:
    """The verdict, the pairs, deepest first, and the least distance."""
    yield title(data, "collision check")
    if data["pairs"]:
        table = make_table(["robot", "link", "other"], ["apart [mm]"], ["normal", "at [m]"])
        for pair in data["pairs"]:
            vectors = [" ".join(number(x, n) for x in pair[key]) for key, n in (("normal", 2), ("witness_a", 3))]
            table.add_row(pair["name_a"], pair["link"], pair["name_b"], f"{1000 * pair['signed_distance'] + 0.0:.3f}", *vectors)
        yield table
    if data["signed_distance"] is not None:
        yield f"least distance: {1000 * data['signed_distance'] + 0.0:.3f} mm"
    yield Text("collision", "bold red") if data["in_collision"] else Text("free", "bold green")
