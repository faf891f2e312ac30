"""Converts a search for a robot that is far from a meter long to a unit of its own.

Pose errors add lengths and angles, and so do damping and thresholds: this suits arms of about a meter. The units are powers of
two, so conversions are exact.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ulna.engine.records import replaced
from ulna.ik.problem import Problem, rows_for
from ulna.kernels.ik.search_records import Results
from ulna.kernels.layout import COLUMN, KIND, LARGEST, OFFSET, PRISMATIC, RATIO, REVOLUTE

Array = NDArray[np.float64]


Solve = Callable[[Problem, NDArray[np.int64]], tuple[Array, Results]]
"""Computes q (m, ..., n_dof) and info (m, ...) for some targets (m,) of a problem."""


def solved_in_unit(problem: Problem, order: NDArray[np.int64], solve: Solve) -> tuple[Array, Results]:
    """The results of a solver for some targets (m,), computed in the unit of the robot and returned in meters."""
    unit = problem.query.unit
    if unit == 1.0:
        return solve(problem, order)
    is_far = _too_far(problem, order, unit)
    unit_q, unit_info = solve(in_unit(problem, unit), order[~is_far])
    in_meters(problem, unit, unit_q, unit_info)
    if not is_far.any():
        return unit_q, unit_info
    q, info = np.empty((len(order), *unit_q.shape[1:])), np.empty((len(order), *unit_info.shape[1:]), unit_info.dtype)
    q[~is_far], info[~is_far] = unit_q, unit_info
    q[is_far], info[is_far] = solve(problem, order[is_far])
    return q, info


def _too_far(problem: Problem, order: NDArray[np.int64], unit: float) -> NDArray[np.bool_]:
    """Mask of the targets (m,) outside of the kernels' range in a unit: they are out of reach."""
    seeds = rows_for(problem.seeds, order) / _slide_units(problem, unit)
    is_far = (np.abs(problem.targets[order, :3, 3]) > LARGEST * unit).any(axis=1)
    return np.logical_or(is_far, (np.abs(seeds) > LARGEST).any(axis=1))


def in_unit(problem: Problem, unit: float) -> Problem:
    """A problem with all lengths in a unit."""
    slides, chain, targets = _slide_units(problem, unit), problem.chain.copy(), problem.targets.copy()
    for row in chain:
        row[[3, 7, 11]] /= unit
        if int(row[KIND]) == PRISMATIC:
            row[RATIO], row[OFFSET] = row[RATIO] * (slides[int(row[COLUMN])] / unit), row[OFFSET] / unit
    chain.setflags(write=False)  # read-only, as a robot's chain: the entry is compiled for read-only arrays
    targets[:, :3, 3] /= unit
    meters = problem.settings[0]
    settings = replaced(
        problem.settings,
        position_tolerance=meters.position_tolerance / unit,
        slack=meters.slack / np.repeat((unit, 1.0), 3),
        max_square=meters.max_square / (unit * unit),
    )
    with np.errstate(over="ignore"):  # a limit of 1e308 means unlimited
        changed = {name: getattr(problem, name) / slides for name in ("seeds", "bounds", "posture")}
    return replace(problem, chain=chain, targets=targets, settings=settings, **changed)


def in_meters(problem: Problem, unit: float, q: Array, info: Results) -> None:
    """Convert the result of a search in a unit to meters, in place: q (..., n_dof), info (...) except ``residual_square``."""
    q *= _slide_units(problem, unit)
    info["position_error"] *= unit
    info["residual"][..., :3] *= unit


def jacobian_in_unit(problem: Problem, J: Array, unit: float) -> Array:
    """A Jacobian (..., 6, n_dof) with all lengths in a unit."""
    return J * _slide_units(problem, unit) / np.array([unit, unit, unit, 1.0, 1.0, 1.0])[:, None]


def _slide_units(problem: Problem, unit: float) -> Array:
    """The unit of each entry of q: entries that drive only prismatic joints are lengths."""
    kinds = [{int(row[KIND]) for row in problem.chain if int(row[COLUMN]) == j} for j in range(problem.query.tree.n_dof)]
    return np.array([unit if PRISMATIC in of and REVOLUTE not in of else 1.0 for of in kinds])
