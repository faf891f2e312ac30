"""What is asked of a search: targets, seeds, tolerances and budget, checked and in the shapes that the kernels take."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.errors import InputError
from ulna.kernels.lanes import WIDTH
from ulna.kernels.search_layout import (
    MAX_ITERATIONS,
    N_SETTINGS,
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    SEEDED,
    WITH_POSTURE,
)
from ulna.kinematics.positions import as_positions, flat, range_to_sample, refuse_out_of_range
from ulna.model.arrays import as_floats
from ulna.model.tree import Tree

N_RUNS = 100  # starts of eight before the search gives up


@dataclass(frozen=True, eq=False)
class Problem:
    """Targets (n, 4, 4) of batch shape ``batch``, seeds (n or 1, n_dof), posture (n_dof,) and the kernels' settings."""

    targets: NDArray[np.float64]
    batch: tuple[int, ...]
    seeds: NDArray[np.float64]
    posture: NDArray[np.float64]
    settings: NDArray[np.float64]


def make_problem(
    tree: Tree,
    T: ArrayLike,
    home: NDArray[np.float64],
    q_seed: ArrayLike | None,
    posture: ArrayLike | None,
    tolerances: tuple[float, float],
    max_iterations: int,
) -> Problem:
    """Check the arguments of a search. Whether targets are rigid motions the kernels see, at no cost."""
    targets = _targets(T)
    batch = targets.shape[:-2]
    settings = np.empty(N_SETTINGS)
    settings[POSITION_TOLERANCE], settings[ROTATION_TOLERANCE] = _tolerance(*tolerances)
    settings[MAX_ITERATIONS] = as_count("max_iterations", max_iterations)
    settings[SEEDED], settings[WITH_POSTURE] = q_seed is not None, posture is not None
    return Problem(
        targets=targets.reshape(-1, 4, 4),
        batch=batch,
        seeds=home.copy().reshape(1, -1) if q_seed is None else _seeds(tree, q_seed, batch),
        posture=home.copy() if posture is None else _posture(tree, posture),
        settings=settings,
    )


@lru_cache(maxsize=64)
def random_starts(bounds: tuple[tuple[float, ...], tuple[float, ...]], seed: int) -> NDArray[np.float64]:
    """Starts within the limits, shape (N_RUNS, n_dof, 8): the same for the same limits and seed."""
    low, high = range_to_sample(*bounds)
    share = np.random.default_rng(seed).random((N_RUNS, len(low), WIDTH))
    starts = np.clip(low[:, None] + share * (high - low)[:, None], low[:, None], high[:, None])
    starts.setflags(write=False)
    return starts


def _targets(T: ArrayLike) -> NDArray[np.float64]:
    targets = as_floats("T", T)
    if targets.shape[-2:] != (4, 4):
        raise InputError("T", f"shape {targets.shape}, but targets have shape (..., 4, 4); ulna.pose(xyz, rpy) makes one")
    return targets


def _seeds(tree: Tree, q_seed: ArrayLike, batch: tuple[int, ...]) -> NDArray[np.float64]:
    """One seed for all targets or one for each, moved into the limits."""
    seeds = as_positions(q_seed, tree, "q_seed")
    refuse_out_of_range(seeds, "q_seed")
    seeds = np.clip(seeds, tree.lower, tree.upper)
    if seeds.ndim == 1:
        return seeds.reshape(1, -1)
    try:
        return flat(np.ascontiguousarray(np.broadcast_to(seeds, (*batch, tree.n_dof))))
    except ValueError:
        message = f"shape {seeds.shape} does not go with targets of batch shape {batch}: give one seed, or one for each target"
        raise InputError("q_seed", message) from None


def _posture(tree: Tree, posture: ArrayLike) -> NDArray[np.float64]:
    goal = as_positions(posture, tree, "posture")
    if goal.ndim != 1:
        raise InputError("posture", f"shape {goal.shape}, but one posture, shape ({tree.n_dof},), serves all targets")
    refuse_out_of_range(goal, "posture")
    return np.clip(goal, tree.lower, tree.upper)


def _tolerance(position: float, rotation: float) -> tuple[float, float]:
    for name, value in (("position_tolerance", position), ("rotation_tolerance", rotation)):
        if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)) or not 0 < value < np.inf:
            raise InputError(name, f"{value!r}; a number above 0 is expected")
    return position, rotation


def as_count(name: str, value: int) -> int:
    """A whole number of at least 0, or an ``InputError`` that names it."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < 2**31:
        raise InputError(name, f"{value!r}; a whole number of at least 0 is expected")
    return int(value)
