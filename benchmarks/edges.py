"""A search for an edge that is called free and touches: ``python -m benchmarks.edges --minutes 10 --seed 1``.

The edges are those of ``tests/grazing.py``, on each of which two bodies share a point by the way it is made. One line for each
pair of kinds: how many edges, how many of them begin apart, and how many were called free. Exit status 1 if any was.
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
    """How many edges in so long, how many begin apart, and how many are called free."""
    rng, end = np.random.default_rng((seed, *map(ord, kind + obstacle))), time.monotonic() + seconds
    counts = np.zeros(3, dtype=int)
    while time.monotonic() < end:
        robot, world, a, b = grazing.grazing_edges(rng, kind, obstacle, EDGES)
        found = robot.edge_in_collision(a, b, world, self_collision=False, resolution=1e-5)
        counts += EDGES, np.count_nonzero(found.free_until > 0), np.count_nonzero(~found.in_collision)
    return tuple(counts.tolist())


def main() -> None:
    """Hunt, print, and fail on a find."""
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
