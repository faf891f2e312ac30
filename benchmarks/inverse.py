"""Measures inverse kinematics under each protocol, Ulna and the peers on the same targets, judged by Pinocchio.

Targets are divided into blocks, and the solvers take turns on each block. So a slow machine affects all of them, and the ratio is
taken block by block.
"""

from collections.abc import Sequence

import numpy as np

from ulna.bench.protocol import PROTOCOLS, Forward, Solver, judge, solver_figures
from ulna.bench.timing import time_each
from ulna.robot import Robot

_BLOCK = 50
# Time limit of one solver under one protocol: a slow one gets fewer blocks, and the table states its number of targets.
_LONGEST_S = 15.0
_PASSES = 3


def protocol_rows(name: str, robot: Robot, protocol_name: str, solvers: Sequence[Solver], n: int, forward: Forward) -> list[dict]:
    """A row for each solver, Ulna first; ``times_ulna`` is the mean time of a block relative to Ulna's."""
    protocol = PROTOCOLS[protocol_name]
    targets, start = protocol.targets(robot, n), protocol.start(robot)
    claimed = {solver.name: [] for solver in solvers}
    good = {solver.name: [] for solver in solvers}
    times = {solver.name: [] for solver in solvers}
    for first in range(0, n, _BLOCK):
        block = targets[first : first + _BLOCK]
        for solver in solvers:
            if sum(map(np.sum, times[solver.name])) * 1e-9 * (_PASSES + 1) > _LONGEST_S:
                continue
            said, true = judge(solver, robot, protocol, block, forward)
            claimed[solver.name].append(said)
            good[solver.name].append(true)
            times[solver.name].append(time_each(solver.solve, [(solver.prepare(T), start) for T in block], _PASSES))
    yardstick = [float(np.mean(block)) for block in times[solvers[0].name]]
    return [
        _row(name, protocol_name, solver.name, *(np.concatenate(d[solver.name]) for d in (claimed, good, times)),
             [float(np.mean(block)) / unit for block, unit in zip(times[solver.name], yardstick, strict=False)])
        for solver in solvers
    ]  # fmt: skip


def _row(name: str, protocol: str, library: str, claimed, good, times_ns, ratios: Sequence[float]) -> dict:
    lower, median, upper = np.percentile(ratios, (25, 50, 75))
    return {
        "robot": name,
        "protocol": protocol,
        "library": library,
        **solver_figures(claimed, good, times_ns),
        "times_ulna": float(median),
        "times_ulna_lower": float(lower),
        "times_ulna_upper": float(upper),
    }
