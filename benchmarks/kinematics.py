"""Measures forward kinematics and Jacobians, single and in batches, interleaved with the peers; ratios pass by pass."""

from time import perf_counter_ns

import numpy as np

from benchmarks.peer import Peer
from benchmarks.ratio import ratio
from ulna.bench.arms import random_positions
from ulna.bench.timing import Timing, Workload, time_interleaved
from ulna.robot import Robot

ONE, LOOP, BATCH = 64, 128, 4096
# A pass is shorter than a process's time slice: other work would interrupt a longer one.
_PASS_NS = 1_000_000


def single_call_rows(name: str, robot: Robot, peers: dict[str, Peer], kind: str) -> list[dict]:
    """One call for one q: ``kind`` is "forward_kinematics" or "jacobian"."""
    q = random_positions(robot, ONE, seed=0)
    bound, out = (
        (robot.compile_forward(), np.empty((4, 4)))
        if kind == "forward_kinematics"
        else (robot.compile_jacobian(), np.empty((6, robot.n_dof)))
    )
    works = {
        "ulna": Workload(getattr(robot, kind), list(q)),
        "ulna, bound": Workload(bound, list(q)),
        "ulna, bound, out=": Workload(lambda x: bound(x, out), list(q)),  # the lambda's cost is part of it
    }
    for peer, offers in peers.items():
        function = offers.forward if kind == "forward_kinematics" else offers.jacobian
        if function is not None:
            works[peer] = Workload(function, short(function, [offers.own_q(x) for x in q]))
        if kind == "forward_kinematics" and offers.forward_kept is not None:
            works[f"{peer}, placement kept"] = Workload(offers.forward_kept, [offers.own_q(x) for x in q])
    return rows_of(name, kind, time_interleaved(works, passes=81))


def batch_rows(name: str, robot: Robot, peers: dict[str, Peer], kind: str) -> list[dict]:
    """A batch of q: Ulna in one call, the peers in a Python loop (over a part) or one call."""
    q = random_positions(robot, BATCH, seed=0)
    works = {"ulna": Workload(getattr(robot, kind), [q], BATCH)}
    for peer, offers in peers.items():
        function = offers.forward if kind == "forward_kinematics" else offers.jacobian
        if function is not None:
            some = short(function, [offers.own_q(x) for x in q[:LOOP]])
            works[f"{peer}, in a loop"] = Workload(_loop(function), [some], len(some))
        at_once = offers.forward_batch if kind == "forward_kinematics" else offers.jacobian_batch
        if at_once is not None:
            works[f"{peer}, at once"] = Workload(at_once, [q], BATCH)
    return rows_of(name, f"{kind}, {BATCH} at once", time_interleaved(works, passes=41))


def short(function, inputs: list) -> list:
    """The first inputs, as many as fit into a short pass."""
    times = []
    for _ in range(3):  # the first may compile
        start = perf_counter_ns()
        function(inputs[0])
        times.append(perf_counter_ns() - start)
    return inputs[: max(1, int(_PASS_NS / max(1, min(times))))]


def _loop(function):
    return lambda batch: [function(q) for q in batch]


def rows_of(name: str, kind: str, timings: dict[str, Timing]) -> list[dict]:
    """A row for each library, with its time as a multiple of Ulna's, pass by pass."""
    rows = []
    for library, timing in timings.items():
        lower, median, upper = ratio(timing, timings["ulna"])
        rows.append({
            "robot": name,
            "work": kind,
            "library": library,
            "median_ns": timing.median,
            "lower_ns": timing.lower,
            "upper_ns": timing.upper,
            "times_ulna": median,
            "times_ulna_lower": lower,
            "times_ulna_upper": upper,
        })  # fmt: skip
    return rows
