"""The figures of docs/performance.md, docs/comparison.md and the README: ``python -m benchmarks.summary RESULT.json``.

Nothing is copied by hand: what stands between the two marks of a page is written anew, and so are those rows of the README's
table that are rows of the comparison.
"""

import json
import sys
from pathlib import Path

from benchmarks.beside import beside_rows, solved
from benchmarks.markdown import table
from ulna.bench.protocol import PROTOCOLS

DOCS = Path(__file__).parents[1] / "docs"
BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"
GROWTH = {
    "bounds": "Distance from the bound",
    "scaling_with_joints": "Cost against joints",
    "scaling_with_rows": "Cost against rows and processors",
    "collision": "Collision, on one processor",
    "scaling_with_pairs": "Cost against pairs of boxes",
    "edges": "Edges, certified",
    "moving": "One object moved, then one configuration checked",
    "first_use": "First use, machine code cached",
    "first_use_ever": "First use ever, with compilation",
    "memory": "Memory of a batch",
}
README_PEERS = ("Pinocchio", "Robotics Toolbox", "MuJoCo", "TRAC-IK", "ikpy")
SOLVERS = ("roboticstoolbox-python", "pytracik", "frankik", "ssik", "EAIK")


def summary(data: dict, name: str) -> str:
    """The page's tables."""
    facts = data["machine"]
    versions = ", ".join(f"{peer} {version}" for peer, version in data["versions"].items())
    machine = (
        f"{facts['processor']}, {facts['cores']} cores, {facts['register_bits']}-bit registers; "
        f"machine code {facts['machine_code']}; Python {facts['python']}, "
        f"NumPy {facts['numpy']}, Numba {facts['numba']}; {versions}. Everything of this run: `benchmarks/results/{name}`."
    )
    parts = [machine]
    for kind, title in (("forward_kinematics", "One `forward_kinematics(q)`"), ("jacobian", "One `jacobian(q)`")):
        parts += [f"**{title}**", table([_call(row) for row in data[kind]])]
    parts += ["**Where the time of one call goes**", table(data["account"])] if data["account"] else []
    parts += ["**Batches**", table([_call(row) for row in data["batches"]])]
    parts += ["**Dynamics, on one processor**", table([_call(row) for row in data["forces"]])] if data.get("forces") else []
    for protocol in PROTOCOLS:
        parts += [f"**Inverse kinematics, protocol {protocol}**", table(solver_rows(data["protocols"], protocol))]
    parts += ["**Tracking**", table([_step(row) for row in data["tracking"]])]
    for key, title in GROWTH.items():
        compiled = key != "first_use_ever" or "ahead" not in facts["machine_code"]
        parts += [f"**{title}**", table(data[key])] if data.get(key) and compiled else []
    if data["absent"]:
        parts += ["**Peers that are not in a table**", table(data["absent"])]
    return "\n\n".join(parts)


def solver_rows(rows: list[dict], protocol: str) -> list[dict]:
    """A row for each robot: Ulna's figures, and for each peer how many it solves and how many times as long it takes."""
    found = {}
    for row in rows:
        if row["protocol"] == protocol:
            found.setdefault(row["robot"], {})[row["library"]] = row
    return [_robot(name, by_library) for name, by_library in found.items()]


def _robot(name: str, by_library: dict) -> dict:
    ulna = by_library["ulna"]
    figures = {
        "robot": name,
        "targets": ulna["targets"],
        "solved %": ulna["solved_percent"],
        "mean us": ulna["mean_us"],
        "p99 us": ulna["p99_us"],
    }
    for peer in SOLVERS:
        row = by_library.get(peer)
        figures[peer] = _peer(row, ulna["targets"]) if row else ""
    return figures


def _peer(row: dict, targets: int) -> str:
    fewer = f" (of {row['targets']})" if row["targets"] != targets else ""  # where it is too slow for all
    return f"{row['solved_percent']:.4g} %{fewer}, {row['times_ulna']:.3g}x"


def _call(row: dict) -> dict:
    quartiles = f"{row['times_ulna_lower']:.3g} to {row['times_ulna_upper']:.3g}"
    return {
        "robot": row["robot"], "work": row["work"], "library": row["library"],
        "median ns": row["median_ns"], "times Ulna": row["times_ulna"], "quartiles": quartiles,
    }  # fmt: skip


def _step(row: dict) -> dict:
    return {
        "robot": row["robot"], "library": row["solver"], "poses": row["poses"], "solved %": row["solved_percent"],
        "path's largest step": row["path_step"], "largest step": row["largest_step"], "steps above 0.1": row["steps_above_bound"],
        "mean us": row["mean_us"],
    }  # fmt: skip


def comparison(data: dict, name: str) -> str:
    """The figures of the page that compares."""
    machine, load = data["machine"], data["machine"]["load"]
    run = f"`benchmarks/results/{name}`: commit {machine['commit']}, load {load} at its beginning."
    return f"{run}\n\n{table(beside_rows(data))}\n\nSolved to 1e-5 m and 1e-5 rad: {solved(data)}"


def write(page: Path, figures: str) -> None:
    """Put the figures between the marks of a page."""
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    page.write_text(f"{before}{BEGIN}\n\n{figures}\n\n{END}{after}", encoding="utf-8")


def write_rows(page: Path, rows: list[dict[str, str]]) -> None:
    """Write the rows of a page's table anew that are among these."""
    known = {row["work"]: f"| {row['work']} | 1 | {' | '.join(row[peer] for peer in README_PEERS)} |" for row in rows}
    lines = page.read_text(encoding="utf-8").split("\n")
    page.write_text("\n".join(known.get(line[2:].partition(" |")[0], line) for line in lines), encoding="utf-8")


def main() -> None:
    """Write the pages' figures anew."""
    result = Path(sys.argv[1])
    data, name = json.loads(result.read_text(encoding="utf-8")), result.with_suffix(".md").name
    write(DOCS / "performance.md", summary(data, name))
    write(DOCS / "comparison.md", comparison(data, name))
    write_rows(DOCS.parent / "README.md", beside_rows(data))


if __name__ == "__main__":
    main()
