"""Deforms a path at random to shorten its motion time: points are moved, inserted or removed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FIRST_STEP, _MIN_STEP, _MAX_STEP = 0.3, 0.02, 0.6  # [rad]: standard deviation of a point's step: initial, minimum, maximum
_LESS, _MORE = 0.97, 1.5  # factor of the step after a failure, after a success
_OWN_STREAM = 0x717569636B


def find_faster_path(
    path: Array, steps: Array, first: int, bounds: tuple[Array, Array], tries: int, seed: int,
    duration_of: Callable[[Array], float], is_free: Callable[[Array], bool],
) -> Array:  # fmt: skip
    """The path with the shortest motion time among the candidates and the path itself.

    The method is random search (Matyas 1965) over the points of the path. Steps grow after a success and shrink after a failure.

    Args:
        path: The path, shape (n, n_dof), n >= 2.
        steps: The change of each entry of q that counts as one radian, 0 for fixed entries, shape (n_dof,).
        first: The index of the first point that may change; the last point stays.
        bounds: The lower and upper limits of q, shape (n_dof,) each.
        tries: The number of candidates.
        seed: Seed of the random numbers.
        duration_of: A function that returns the time of a motion along a path [s].
        is_free: A function that checks whether the edges of a path from point ``first`` - 1 on are free.
    """
    rng, best, reach = np.random.default_rng([_OWN_STREAM, seed]), duration_of(path), _FIRST_STEP
    for _ in range(tries):
        candidate = _deform(path, steps, first, reach, rng)
        candidate[first:-1] = np.clip(candidate[first:-1], *bounds)
        duration = duration_of(candidate) if is_free(candidate[first - 1 :]) else np.inf
        if duration < best:
            path, best, reach = candidate, duration, min(_MORE * reach, _MAX_STEP)
        else:
            reach = max(_LESS * reach, _MIN_STEP)
    return path


def _deform(path: Array, steps: Array, first: int, reach: float, rng: np.random.Generator) -> Array:
    """A copy of the path with one point moved in half of its entries, removed, or inserted."""
    n, choice = len(path), rng.random()
    step = reach * rng.normal(size=path.shape[1]) * steps
    if n > first + 1 and choice < 0.8:
        k = int(rng.integers(first, n - 1))
        if choice > 0.7:
            return np.delete(path, k, axis=0)
        moved = path.copy()
        moved[k] += step * (rng.random(len(step)) < 0.5)
        return moved
    k = int(rng.integers(first, n))
    return np.insert(path, k, path[k - 1] + rng.random() * (path[k] - path[k - 1]) + step, axis=0)
