"""Writes the figures of docs/performance*.md and of the README: ``python -m benchmarks.summary RESULT.json``.

Nothing is copied by hand. A page names each block of figures: ``<!-- figures: NAME -->`` before it, ``<!-- end -->`` after it.
``tables`` lists the names. In the README's table the rows of the block ``comparison`` are replaced.
"""

import json
import re
import sys
from pathlib import Path

from benchmarks.beside import WORDS as OF_SCENES
from benchmarks.beside import beside_rows, solved
from benchmarks.markdown import table
from ulna.bench.protocol import PROTOCOLS

DOCS = Path(__file__).parents[1] / "docs"
MARKED = re.compile(r"<!-- figures: (?P<name>[^>]+?) -->\n.*?<!-- end -->", re.DOTALL)
GROWTH = (
    "account", "bounds", "scaling_with_joints", "scaling_with_rows", "collision", "scaling_with_pairs", "edges", "moving",
    "first_use", "first_use_ever", "memory", "absent",
)  # fmt: skip
COLUMNS = {
    "operations_on_eight": "vector operations",
    "bytes_a_row": "bytes per row",
    "arithmetic_ns": "arithmetic bound [ns]",
    "memory_ns": "memory bound [ns]",
    "median_ns": "median [ns]",
    "times_bound": "median / bound",
    "one_ns": "one call [ns]",
    "batch_ns": "row of a batch [ns]",
    "batch_ns_a_joint": "row of a batch, per joint [ns]",
    "bound_ns": "bound [ns]",
    "one_processor_ns": "one core [ns]",
    "all_processors_ns": "all cores [ns]",
    "gain": "speedup",
    "asked": "call",
    "ulna_ns": "Ulna [ns]",
    "pin_and_coal_ns": "Pinocchio and Coal [ns]",
    "times_ulna": "times Ulna",
    "world": "scene",
    "built_ms": "first use of the world [ms]",
    "distance_ns": "signed_distance, row of a batch [ns]",
    "in_collision": "of these in collision",
    "edge_ns": "time per edge [ns]",
    "moved_ns": "move and check [ns]",
    "asked_ns": "check alone [ns]",
    "extra_megabytes": "memory beside input and result [MB]",
}
WORDS = {
    **OF_SCENES,
    "as dense": "constant density",
    "denser": "growing density",
    "pin, placement kept": "pin, placement object kept",
}
README_PEERS = ("Pinocchio", "Robotics Toolbox", "MuJoCo", "TRAC-IK", "ikpy")
SOLVERS = ("roboticstoolbox-python", "pytracik", "frankik", "ssik", "EAIK")


def tables(data: dict, name: str) -> dict[str, str]:
    """Every block of figures in Markdown, by the name in the mark of its page."""
    facts = data["machine"]
    versions = ", ".join(f"{peer} {version}" for peer, version in data["versions"].items())
    blocks = {
        "machine": f"{facts['processor']}, {facts['cores']} cores, {facts['register_bits']}-bit registers; "
        f"machine code {facts['machine_code'].replace('ahead', 'compiled ahead')}; Python {facts['python']}, "
        f"NumPy {facts['numpy']}, Numba {facts['numba']}; {versions}. "
        f"Commit {facts['commit']}; the full result is `benchmarks/results/{name}`.",
        "comparison": f"{table(beside_rows(data))}\n\nSolved to 1e-5 m and 1e-5 rad: {solved(data)}",
        "tracking": table([_step(row) for row in data["tracking"]]),
    }
    for key in ("forward_kinematics", "jacobian", "batches", "forces"):
        blocks[key] = table([_call(row, one_kind=key == row["work"]) for row in data[key]])
    for protocol in PROTOCOLS:
        blocks[f"protocol {protocol}"] = table(solver_rows(data["protocols"], protocol))
    for key in GROWTH:
        if data.get(key):
            blocks[key] = table([_renamed(row) for row in data[key]])
    return blocks


def _renamed(row: dict) -> dict:
    """A row with the column names and words for a reader of the page."""
    row = dict(row)
    if "seconds" in row:
        row["time [ms]"] = 1e3 * row.pop("seconds")
    if "times_ulna_lower" in row:
        row["quartiles"] = f"{row.pop('times_ulna_lower'):.3g} to {row.pop('times_ulna_upper'):.3g}"
    return {COLUMNS.get(key, key): WORDS.get(value, value) if isinstance(value, str) else value for key, value in row.items()}


def solver_rows(rows: list[dict], protocol: str) -> list[dict]:
    """A row for each robot: Ulna's figures, and each peer's share of solved targets and relative time."""
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
        "mean [us]": ulna["mean_us"],
        "p99 [us]": ulna["p99_us"],
    }
    for peer in SOLVERS:
        row = by_library.get(peer)
        figures[peer] = _peer(row, ulna["targets"]) if row else ""
    return figures


def _peer(row: dict, targets: int) -> str:
    fewer = f" (of {row['targets']})" if row["targets"] != targets else ""  # too slow for all targets
    return f"{row['solved_percent']:.4g} %{fewer}, {row['times_ulna']:.3g}x"


def _call(row: dict, *, one_kind: bool) -> dict:
    quartiles = f"{row['times_ulna_lower']:.3g} to {row['times_ulna_upper']:.3g}"
    return {
        "robot": row["robot"], **({} if one_kind else {"work": row["work"]}),
        "library": WORDS.get(row["library"], row["library"]),
        "median [ns]": row["median_ns"], "times Ulna": row["times_ulna"], "quartiles": quartiles,
    }  # fmt: skip


def _step(row: dict) -> dict:
    return {
        "robot": row["robot"], "library": row["solver"], "poses": row["poses"], "solved %": row["solved_percent"],
        "largest step of the path": row["path_step"], "largest step of the solver": row["largest_step"],
        "steps above 0.1": row["steps_above_bound"], "mean [us]": row["mean_us"],
    }  # fmt: skip


def write(page: Path, blocks: dict[str, str]) -> None:
    """Replace the figures between each pair of marks of a page; blocks missing in the run stay unchanged."""
    text = page.read_text(encoding="utf-8")
    page.write_text(re.sub(MARKED, lambda found: _block(found, blocks), text), encoding="utf-8")


def _block(found: re.Match, blocks: dict[str, str]) -> str:
    figures = blocks.get(found["name"])
    return found[0] if figures is None else f"<!-- figures: {found['name']} -->\n\n{figures}\n\n<!-- end -->"


def write_rows(page: Path, rows: list[dict[str, str]]) -> None:
    """Replace those rows of a page's table that are among ``rows``."""
    known = {row["work"]: f"| {row['work']} | 1 | {' | '.join(row[peer] for peer in README_PEERS)} |" for row in rows}
    lines = page.read_text(encoding="utf-8").split("\n")
    page.write_text("\n".join(known.get(line[2:].partition(" |")[0], line) for line in lines), encoding="utf-8")


def main() -> None:
    """Update the figures of all pages."""
    result = Path(sys.argv[1])
    data, name = json.loads(result.read_text(encoding="utf-8")), result.with_suffix(".md").name
    blocks = tables(data, name)
    for page in sorted(DOCS.glob("performance*.md")):
        write(page, blocks)
    write_rows(DOCS.parent / "README.md", beside_rows(data))


if __name__ == "__main__":
    main()
