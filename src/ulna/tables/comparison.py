"""``ulna compare`` for people."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from ulna.tables.writing import make_table


def comparison_view(data) -> Iterator[RenderableType]:
    """The differences one by one, how far the links are apart, and the verdict."""
    by_order = "; names differ, so joints are matched by their order" if data["matched_by"] == "order" else ""
    yield Text.assemble((f"a: {data['name_a']}, b: {data['name_b']}", "bold"), by_order)
    if data["differences"]:
        table = make_table(["", "where", "a", "b"], [], [])
        table.columns[0].no_wrap = True
        for difference in data["differences"]:
            table.add_row(*(difference[key] for key in ("kind", "where", "a", "b")))
        yield table
    yield _farthest(data)
    count = len(data["differences"])
    words = f"{count} difference{'s' * (count != 1)}"
    yield Text("the same", "bold green") if data["same"] else Text(words, "bold red")


def _farthest(data) -> str:
    if not data["poses"]:
        return "no links stand for each other"
    farthest = max(data["poses"], key=lambda pose: (pose["position"], pose["rotation"]))
    where = f" ({farthest['link_a']})" if farthest["position"] > 0 else ""
    apart = f"{data['max_position_difference']:.3g} m{where}, {data['max_rotation_difference']:.3g} rad"
    return f"largest pose difference of {len(data['poses'])} links, in {data['frame_a']}: {apart}"
