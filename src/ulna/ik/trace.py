"""Replays how a search converged, step by step from the start that led to its result."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.ik.problem import Problem
from ulna.ik.restarts import Restart, run_starts
from ulna.ik.unit_samples import unit_samples
from ulna.kernels.ik import search_layout as layout

Array = NDArray[np.float64]


def convergence(problem: Problem, info: Array, origin: Array | None = None, *, with_posture: bool = False) -> Array:
    """A row a step towards the result with this information: errors [m] and [rad], largest joint step, damping; (steps + 1, 4).

    origin: where the result was searched from, (n_dof,), if by no start of a round.

    A step depends on the configuration alone, so taking them one at a time gives the same result.
    """
    start, steps = int(info[layout.START]), int(info[layout.ITERATIONS])
    q = _start(problem, start) if origin is None else origin
    rows = []
    for k in range(steps + 1):
        here = replace(problem, seeds=q[None], nearest_to=None)
        _, before = run_starts(here, np.zeros(1, dtype=np.int64), Restart(0, 1, 0, from_seed=True, with_posture=with_posture))
        after, _ = run_starts(here, np.zeros(1, dtype=np.int64), Restart(0, 1, 1, from_seed=True, with_posture=with_posture))
        step = np.abs(after[0, 0] - q).max() if k < steps else 0.0
        rows.append([*before[0, 0, [layout.POSITION_ERROR, layout.ROTATION_ERROR]], step, before[0, 0, layout.DAMPING]])
        q = after[0, 0]
    table = np.array(rows)
    table[1:, 2], table[0, 2] = table[:-1, 2].copy(), 0.0
    return table


def _start(problem: Problem, start: int) -> Array:
    if start == 0:
        return problem.seeds[0]
    query = problem.query
    lower, upper, low, high = problem.bounds[0]
    share = unit_samples(query.tree, query.link, query.options.seed, start - 1, 1)[0]
    return np.clip(np.where(np.isnan(share), problem.seeds[0], low + share * (high - low)), lower, upper)
