"""``ulna inspect``: lists the defects of a description."""

from collections.abc import Iterator
from dataclasses import asdict

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from ulna.cli.depends import command
from ulna.cli.options import RobotName, Sources
from ulna.cli.output import Output, make_table
from ulna.errors import count_of
from ulna.inspection.inspect import inspect as inspect_description
from ulna.inspection.result import Severity

INSPECT_KEYS = (
    "source; name; loads: whether Ulna takes it; n_dof and reach (m): null if not; closed_form: of inverse kinematics, empty if "
    "there is none; n_links; joint_types: how many of each; "
    "counts: error, warning, note; findings, worst first: severity, where, message, line, tried (the paths where a mesh was "
    "looked for); tree: depth, link, joint, type."
)
_EXIT_STATUS = {None: 0, Severity.NOTE: 0, Severity.WARNING: 1, Severity.ERROR: 2}
_STYLES = {"error": "bold red", "warning": "yellow", "note": "dim"}
_MAX_LINKS = 60  # maximum number of links in the drawn tree: one page


@command
def inspect(sources: Sources, *, robot: RobotName = "panda") -> Output:
    """Check a description, even one that cannot be loaded: limits, axes, units, meshes, inertia, and its tree.

    Exit status 0 if nothing is wrong (notes do not count), 1 for warnings, 2 for errors.
    """
    inspection = inspect_description(robot, **sources)
    data = {**asdict(inspection), "counts": {severity.value: inspection.count(severity) for severity in Severity}}
    return Output(data, inspect_table, _EXIT_STATUS[inspection.worst])


def inspect_table(data) -> Iterator[RenderableType]:
    """Show the robot in a line, its tree, the findings with the paths that were tried, and their counts."""
    yield from _heading(data)
    yield from _drawn_tree(data["tree"])
    if not data["findings"]:
        yield ""
    else:
        table = make_table(["", "where", "finding"], [], [])
        table.columns[0].no_wrap = True
        for (severity, message), places in _places_by_message(data["findings"]).items():
            table.add_row(Text(severity, _STYLES[severity]), "\n".join(_first_few(places)), message)
        yield table
    for finding in data["findings"]:
        if finding["tried"]:
            yield Text.assemble(("tried", "bold"), f", for {finding['tried'][0].rpartition('/')[2]}:")
            yield from (Text(f"  {path}", no_wrap=True) for path in finding["tried"])
    yield _counts(data["counts"])


def _heading(data) -> Iterator[Text]:
    yield Text.assemble((data["source"], "bold"), f": {data['name']}" * bool(data["name"]))
    kinds = ", ".join(f"{count} {kind or 'of no type'}" for kind, count in data["joint_types"].items())
    joints = count_of(sum(data["joint_types"].values()), "joint") + f" ({kinds})" * bool(kinds)
    parts = f"{count_of(data['n_links'], 'link')}, {joints}"
    if data["loads"]:
        yield Text(f"{data['n_dof']} dof, {parts}, reach {data['reach']:.3g} m")
        if data["closed_form"]:
            yield Text(f"closed form of inverse kinematics {data['closed_form']}")
    else:
        yield Text.assemble(("cannot be loaded", "bold red"), f": {parts}" * bool(data["n_links"]))


def _drawn_tree(rows) -> Iterator[RenderableType]:
    """Draw the tree with two characters per level; names of fixed joints are omitted."""
    open_levels, last = set(), _last_children(rows)
    if rows:
        yield ""
    for k, row in enumerate(rows[:_MAX_LINKS]):
        depth = row["depth"]
        if depth:
            yield _branch(row, open_levels, closes=k in last)
        else:
            yield Text(row["link"], "bold")
        open_levels = {level for level in open_levels if level < depth} | ({depth} if depth and k not in last else set())
    if len(rows) > _MAX_LINKS:
        yield f"... and {len(rows) - _MAX_LINKS} more"


def _branch(row, open_levels: set[int], *, closes: bool) -> Table:
    bars = "".join("│ " if level in open_levels else "  " for level in range(1, row["depth"]))
    joint = "fixed" if row["type"] == "fixed" else f"{row['joint']}: {row['type']}"
    line = Table.grid()
    line.add_column(no_wrap=True)
    line.add_column(overflow="fold")
    line.add_row(Text(bars + ("└ " if closes else "├ "), "dim"), Text.assemble(row["link"], (f"  {joint}", "dim")))
    return line


def _last_children(rows) -> set[int]:
    """Indices of the rows that are the last child of their parent."""
    last: set[int] = set()
    following: list[bool] = []  # for each level, whether a later row is a child of the same parent
    for k in range(len(rows) - 1, -1, -1):
        depth = rows[k]["depth"]
        del following[depth + 1 :]
        following += [False] * (depth + 1 - len(following))
        if not following[depth]:
            last.add(k)
        following[depth] = True
    return last


def _places_by_message(findings) -> dict[tuple[str, str], list[str]]:
    """Group the places by severity and message, in the order of the findings."""
    places: dict[tuple[str, str], list[str]] = {}
    for finding in findings:
        line = f" (line {finding['line']})" if finding["line"] else ""
        places.setdefault((finding["severity"], finding["message"]), []).append(finding["where"] + line)
    return places


def _first_few(places: list[str], most: int = 3) -> list[str]:
    return places if len(places) <= most + 1 else [*places[:most], f"and {len(places) - most} more"]


def _counts(counts) -> Text:
    words = [f"{count or 'no'} {kind}{'s' * (count != 1)}" for kind, count in counts.items()]
    style = next((style for kind, style in (("error", "bold red"), ("warning", "bold yellow")) if counts[kind]), "bold green")
    return Text(", ".join(words), style)
