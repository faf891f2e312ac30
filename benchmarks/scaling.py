"""Measures the growth of the cost with joints, rows and processors, next to its bounds.

The bounds are those of ``bounds``: operations counted, bytes moved, at the speeds measured in the same run.
"""

import numpy as np

import ulna
from benchmarks.bounds import count_operations
from benchmarks.processors import one_processor
from ulna.bench.arms import random_positions
from ulna.bench.timing import Workload, time_interleaved
from ulna.engine.lanes import WIDTH
from ulna.robot import Robot

JOINTS = (3, 6, 7, 12, 20, 40, 60)
ROWS = (1, 8, 64, 512, 4096, 32_768, 262_144, 1_000_000)
KINDS = ("forward_kinematics", "jacobian")
BATCH, CALLS = 4096, 64
_LARGEST_ANSWER = 400e6  # bytes: larger batches are omitted
_CACHES = 16e6  # bytes: memory bounds a larger batch, if that takes longer than its arithmetic


def joint_rows(peak: float) -> list[dict]:
    """The time of one call, and of a batch row, for chains with many joints and random DH rows."""
    rows = []
    for joints in JOINTS:
        robot = random_arm(joints)
        q, counts = random_positions(robot, BATCH, 0), count_operations(robot)
        for kind in KINDS:
            ask = getattr(robot, kind)
            times = time_interleaved({"one": Workload(ask, list(q[:CALLS])), "batch": Workload(ask, [q], BATCH)})
            one, batch, bound = times["one"].median, times["batch"].median, counts[kind] / WIDTH * peak
            rows.append({
                "work": kind, "joints": joints, "one_ns": one, "batch_ns": batch, "batch_ns_a_joint": batch / joints,
                "bound_ns": bound, "times_bound": batch / bound,
            })  # fmt: skip
    return rows


def size_rows(robot: Robot, peak: float, copy: float) -> list[dict]:
    """The time of a row for batches of one to a million, on one processor and on all."""
    rows, counts = [], count_operations(robot)
    for kind in KINDS:
        ask = getattr(robot, kind)
        for n in ROWS:
            q = random_positions(robot, n, 0)
            moved = q[0].nbytes + ask(q[:1]).nbytes
            if n * moved > _LARGEST_ANSWER:
                continue
            work, passes = {kind: Workload(ask, [q] * max(1, CALLS // n), n)}, 7 if n >= 100_000 else 21
            with one_processor():
                one = time_interleaved(work, passes)[kind].median
            every = time_interleaved(work, passes)[kind].median
            bound = max(counts[kind] / WIDTH * peak, moved * copy if n * moved > _CACHES else 0.0)
            rows.append({
                "work": kind, "rows": n, "one_processor_ns": one, "all_processors_ns": every, "gain": one / every,
                "bound_ns": bound,
            })  # fmt: skip
    return rows


def random_arm(joints: int) -> Robot:
    """An arm of revolute joints with random DH rows."""
    rng = np.random.default_rng(joints)
    rows = np.column_stack([rng.uniform(-0.3, 0.3, (joints, 2)), rng.uniform(-np.pi, np.pi, (joints, 2))])
    return ulna.Robot.from_dh(rows, limits=[(-np.pi, np.pi)] * joints)
