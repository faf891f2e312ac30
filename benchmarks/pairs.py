"""Pairs of every kind against Coal: agreement, and nanoseconds a pair.

Run: python benchmarks/pairs.py [pairs of boxes] [pairs of every other kind]. These are the million and the hundred thousand that
the tests have no time for. Where the two differ by more than 1e-6 m the row counts how often
Ulna's answer proves itself, so that Coal's cannot be right.
"""

import sys
import time
from functools import partial
from pathlib import Path

import coal
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import kernel_modes
import solids
from coal_pairs import coal_request, coal_scene
from ulna.engine.decorators import routine
from ulna.engine.lanes import load, store, where
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.distance.pairs import pair_distance, pair_overlap
from ulna.kernels.spatial.se3 import load_pose

CHUNK = 4000


@routine
def body(kind, vertices, x):
    """One body of the rows."""
    return kind, load_pose(x, 0), (load(x, 12), load(x, 13), load(x, 14), load(x, 15)), vertices


@routine
def distances(kind_a, vertices_a, kind_b, vertices_b, scratch, x, out):
    """Signed distances of all blocks of rows."""
    for i in range(x.shape[0]):
        store(out[i], 0, pair_distance(body(kind_a, vertices_a, x[i]), body(kind_b, vertices_b, x[i][16:]), scratch)[0])


@routine
def verdicts(kind_a, vertices_a, kind_b, vertices_b, _scratch, x, out):
    """Whether they overlap."""
    for i in range(x.shape[0]):
        overlap = pair_overlap(body(kind_a, vertices_a, x[i]), body(kind_b, vertices_b, x[i][16:]), 1.0)
        store(out[i], 0, where(overlap, 1.0, 0.0))


def nanoseconds(work, n):
    """The median of seven runs, for one of n pairs."""
    work()
    times = []
    for _ in range(7):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e9 * np.median(times) / n


def speed(pairs):
    """Nanoseconds a pair: distance in lanes and one by one, verdict in lanes."""
    columns = np.array([[*solids.kernel_column(a, T_a), *solids.kernel_column(b, T_b)] for a, T_a, b, T_b in pairs])
    kinds = solids.kernel_arguments(pairs[0][0], pairs[0][2])
    scratch = tuple(np.zeros(shape) for shape in SCRATCH)
    n = len(pairs)
    lanes = np.ascontiguousarray(columns.reshape(n // 8, 8, -1).transpose(0, 2, 1))
    out_lanes, out = np.empty((n // 8, 1, 8)), np.empty((n, 1))
    return (
        nanoseconds(lambda: distances(*kinds, scratch, lanes, out_lanes), n),
        nanoseconds(lambda: distances(*kinds, scratch, columns, out), n),
        nanoseconds(lambda: verdicts(*kinds, scratch, lanes, out_lanes), n),
    )


def coal_speed(scene, tolerance):
    """Nanoseconds a pair of Coal called in a loop, results ready-made."""
    request, results = coal_request(tolerance), [coal.DistanceResult() for _ in scene]
    start = time.perf_counter()
    for arguments, result in zip(scene, results, strict=True):
        coal.distance(*arguments, request, result)
    return 1e9 * (time.perf_counter() - start) / len(scene), np.array([result.min_distance for result in results])


def proved(pair, answer):
    """Whether one answer proves itself."""
    try:
        solids.assert_proved([pair], [part[None] for part in answer], 2e-9)
    except AssertionError:
        return False
    return True


def compare(kinds, n):
    """Print one row."""
    rng, tolerance = np.random.default_rng(0), 1e-8 if "cylinder" in kinds else 1e-12
    run = partial(kernel_modes.run, "f64x8")
    verdicts_differ = largest = differ = without_proof = 0
    for start in range(0, n, CHUNK):
        pairs = solids.random_pairs(rng, kinds, CHUNK, 0.4)
        answer = solids.ask(run, pairs)
        slow, expected = coal_speed(coal_scene(pairs), tolerance)
        error, sure = np.abs(answer[0] - expected), np.abs(expected) > 1e-8
        verdicts_differ += int((answer[4] != (expected < 0))[sure].sum())
        odd = np.flatnonzero(error > 1e-6)
        differ += len(odd)
        without_proof += sum(not proved(pairs[k], [part[k] for part in answer]) for k in odd)
        largest = max(largest, np.delete(error, odd).max())
        if start == 0:
            fast, single, verdict = speed(pairs)
            slow_first = slow
    print(f"| {'-'.join(kinds)} | {n} | {verdicts_differ} | {largest:.0e} | {differ} | {without_proof} "
          f"| {fast:.0f} | {verdict:.0f} | {single:.0f} | {slow_first:.0f} | {slow_first / fast:.0f} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    boxes, others = (int(sys.argv[k]) if len(sys.argv) > k else default for k, default in ((1, 1_000_000), (2, 100_000)))
    print("| pair | n | verdicts differ | largest difference [m] | differ by more than 1e-6 | of these not proved "
          "| distance, lanes [ns] | verdict, lanes | distance, one | Coal | Coal / lanes |\n|" + "---|" * 11)  # fmt: skip
    for kinds in solids.PAIRS:
        compare(kinds, boxes if kinds == ("box", "box") else others)
