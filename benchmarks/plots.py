"""Draws the plots of docs/performance_*.md from the figures of a run: ``python -m benchmarks.plots RESULT.json``.

Each plot shows a measured cost, and as a dashed line its lower bound (``bounds``).
"""

import json
import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

from benchmarks.summary import WORDS

FOLDER = Path(__file__).parents[1] / "docs" / "plots"
LINK, OTHER = "#1f77b4", "#d95f02"
COLORS = {"forward_kinematics": LINK, "jacobian": OTHER}
WORLDS = {"as dense": LINK, "denser": OTHER}


def joints_plot(axes, rows: list[dict]) -> None:
    """Plot one call and a row of a batch against the joints of a chain."""
    for kind, color in COLORS.items():
        x, one, batch, bound = columns(rows, "work", kind, "joints", "one_ns", "batch_ns", "bound_ns")
        axes.plot(x, one, "o-", color=color, label=f"{kind}, one call")
        axes.plot(x, batch, "s-", color=color, mfc="white", label=f"{kind}, a row of 4096")
        axes.plot(x, bound, "--", color=color, label="arithmetic bound")
    axes.set_xlabel("joints")
    axes.set_ylabel("ns")


def rows_plot(axes, rows: list[dict]) -> None:
    """Plot a row of a batch against the number of rows, on one processor and on all."""
    for kind, color in COLORS.items():
        x, one, two, bound = columns(rows, "work", kind, "rows", "one_processor_ns", "all_processors_ns", "bound_ns")
        axes.plot(x, one, "o-", color=color, label=f"{kind}, one core")
        axes.plot(x, two, "s:", color=color, mfc="white", label="all cores")
        axes.plot(x, bound, "--", color=color, label="bound: arithmetic, or memory beyond the caches")
    axes.set_xlabel("rows of the batch")
    axes.set_ylabel("ns per row")


def pairs_plot(axes, rows: list[dict]) -> None:
    """Plot a free configuration of a batch against the pairs of boxes."""
    bound = [(row["pairs"], row["bound_ns"]) for row in rows if row["bound_ns"] is not None]
    for world, color in WORLDS.items():
        x, check, distance = columns(rows, "world", world, "pairs", "batch_ns", "distance_ns")
        axes.plot(x, check, "o-", color=color, label=f"in_collision, {WORDS[world]}")
        axes.plot(x, distance, "s:", color=color, mfc="white", label=f"signed_distance, {WORDS[world]}")
    axes.plot(*zip(*sorted(bound), strict=True), "--", color=LINK, label="bound: boxes placed, bounding spheres compared")
    axes.set_xlabel(f"pairs of boxes (above {max(pairs for pairs, _ in bound)} with a BVH)")
    axes.set_ylabel("ns per configuration")


PLOTS = {
    "scaling_with_joints": ("joints", joints_plot),
    "scaling_with_rows": ("rows", rows_plot),
    "scaling_with_pairs": ("pairs", pairs_plot),
}


def columns(rows: list[dict], kind: str, one: str, *keys: str) -> list[list[float]]:
    """The columns of the rows of one kind."""
    return [[row[key] for row in rows if row[kind] == one] for key in keys]


def draw(data: dict, folder: Path) -> list[Path]:
    """Write the plots of a run that has their figures; returns their paths."""
    plt.rcParams.update({"svg.hashsalt": "ulna", "svg.fonttype": "none", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for key, (name, plot) in PLOTS.items():
        if data.get(key):
            figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
            plot(axes, data[key])
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.legend(fontsize=7)
            paths.append(folder / f"{name}.svg")
            figure.savefig(paths[-1], metadata={"Date": None})
            plt.close(figure)
    return paths


def main() -> None:
    """Draw the plots of a result."""
    data = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    for path in draw(data, FOLDER):
        sys.stdout.write(f"{path}\n")


if __name__ == "__main__":
    main()
