"""Formats rows as Markdown tables, and the page of one run."""

from datetime import date

_TITLES = {
    "forward_kinematics": "Forward kinematics, one call",
    "jacobian": "Jacobian, one call",
    "account": "Where the time of one call goes",
    "batches": "Batches",
    "forces": "Dynamics, on one processor",
    "protocols": "Inverse kinematics",
    "tracking": "Tracking a path",
    "scaling_with_joints": "Cost against joints",
    "scaling_with_rows": "Cost against rows and processors",
    "collision": "Collision, on one processor",
    "scaling_with_pairs": "Cost against pairs of boxes",
    "edges": "Edges, certified",
    "moving": "One object moved, then one configuration checked",
    "bounds": "Distance from the bound",
    "first_use": "First use, machine code cached",
    "first_use_ever": "First use ever, with compilation",
    "memory": "Memory of a batch",
    "size": "Size on disk",
    "absent": "Peers that are not in a table",
}


def table(rows: list[dict]) -> str:
    """Format rows; the keys of the first are the columns. Text is left-aligned, numbers right-aligned."""
    if not rows:
        return "Nothing could be measured."
    keys = list(rows[0])
    lines = [keys, ["---" if isinstance(rows[0][key], str) else "---:" for key in keys]]
    lines += [[_cell(row.get(key, "")) for key in keys] for row in rows]
    lines[0] = [key.replace("_", " ") for key in keys]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def page(data: dict) -> str:
    """The page: the machine and the versions, then every table."""
    facts = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in data["machine"].items())
    versions = ", ".join(f"{name} {version}" for name, version in data["versions"].items())
    parts = [f"# Measured on {date.today().isoformat()}", f"{facts}.", f"Peers: {versions}."]  # noqa: DTZ011 -- the reader's day
    for key, rows in data.items():
        if isinstance(rows, list) and rows:
            parts += [f"## {_TITLES.get(key, key)}", table(rows)]
    return "\n\n".join(parts) + "\n"


def _cell(value) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return f"{value:,}" if isinstance(value, int) else str(value)
