"""Searches for a colliding edge that is certified as free: ``python -m benchmarks.edges --minutes 10 --seed 1``.

The edges are those of ``tests/grazing.py``: by construction, two bodies share a point on each. The output has one line per pair
of kinds: the number of edges, of edges that start apart, and of edges called free. Exit status 1 if any was.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import grazing

EDGES = 8  # for each pair of bodies


def hunt(kind: str, obstacle: str, seconds: float, seed: int) -> tuple[int, int, int]:
    """Counts within a time limit: all edges, those that start apart, and those called free."""
    rng, end = np.random.default_rng((seed, *map(ord, kind + obstacle))), time.monotonic() + seconds
    counts = np.zeros(3, dtype=int)
    while time.monotonic() < end:
        robot, world, a, b = grazing.grazing_edges(rng, kind, obstacle, EDGES)
        found = robot.edge_in_collision(a, b, world, self_collision=False, resolution=1e-5)
        counts += EDGES, np.count_nonzero(found.free_until > 0), np.count_nonzero(~found.in_collision)
    return tuple(counts.tolist())


def main() -> None:
    """Search, print, and fail if an edge was found."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.edges", description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    pairs = [(kind, obstacle) for kind in grazing.KINDS for obstacle in grazing.OBSTACLES]
    free = 0
    print(f"{'held':>10} {'obstacle':>10} {'edges':>10} {'apart':>10} {'free':>10}")
    for kind, obstacle in pairs:
        counts = hunt(kind, obstacle, 60 * options.minutes / len(pairs), options.seed)
        free += counts[2]
        print(f"{kind:>10} {obstacle:>10}" + "".join(f" {count:10d}" for count in counts), flush=True)
    sys.exit(free > 0)


if __name__ == "__main__":
    main()
