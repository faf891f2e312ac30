"""Shortens a joint path through poses by moving along the redundancy."""

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.course import Course

Array = NDArray[np.float64]
_ROUNDS = 12


def smoothed(course: Course, q: Array, width: int) -> Array:
    """A path (n, n_dof) of the same poses whose squared steps are fewer, or the same; begun near the start as before.

    Guesses are the means over up to 2 ``width`` + 1 poses, brought to the poses by the search. A round that makes the path
    longer, or lets it jump, leave the limits or collide, is undone, and the width halved.
    """
    for _ in range(_ROUNDS):
        better = _once(course, q, width)
        if better is not None:
            q = better
        elif width > 1:
            width = max(1, width // 2)
        else:
            break
    return q


def _once(course: Course, q: Array, width: int) -> Array | None:
    guesses = _means(q, width)
    if course.started:
        guesses[0] = q[0]
    moved, found = course.near(np.arange(len(q)), guesses)
    if not found.all() or _length(course, moved) >= _length(course, q) or np.abs(np.diff(moved, axis=0)).max() > course.max_step:
        return None
    return None if course.collide(moved).any() or course.edges_collide(moved[:-1], moved[1:]).any() else moved


def _length(course: Course, q: Array) -> float:
    """What is minimised: the costs of the rank and the squared steps."""
    return float(course.costs(q).sum() + course.weight * (np.diff(q, axis=0) ** 2).sum())


def _means(q: Array, width: int) -> Array:
    """The means of each row and up to ``width`` rows on either side, as many on one as on the other."""
    n = len(q)
    sums = np.vstack([np.zeros(q.shape[1]), np.cumsum(q, axis=0)])
    k = np.arange(n)
    half = np.minimum(np.minimum(k, n - 1 - k), width)
    return (sums[k + half + 1] - sums[k - half]) / (2 * half + 1)[:, None]
