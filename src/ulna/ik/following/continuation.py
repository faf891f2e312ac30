"""Continues a joint path pose by pose, from many configurations of the redundancy at once.

Each pose has a set of configurations in which a path ends. Guesses are these and some at random distances from them, brought
to the next pose by the search. Kept is what is within the limits, no more than a step away and clear of the world, none near
another.
"""

import numpy as np
from numpy.typing import NDArray

from ulna.ik.following.course import Course

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
_MOST, _GUESSES = 64, 6  # configurations, and guesses from each


def continued(course: Course, q: Array) -> tuple[Array, Array]:
    """The path (k, n_dof) as far as it can be continued, and all configurations known in which it could end, shape (m, n_dof)."""
    if not len(q):
        return q, q
    sets, parents = [q[-1:]], [np.zeros(1, dtype=np.int64)]
    rng = np.random.default_rng(course.query.options.seed)
    for k in range(len(q), len(course.targets)):
        following, come_from = _next(course, k, sets[-1], rng)
        if not len(following):
            break
        sets.append(following)
        parents.append(come_from)
    return np.vstack([q, _back(sets, parents)]), sets[-1]


def _next(course: Course, k: int, ends: Array, rng: np.random.Generator) -> tuple[Array, Counts]:
    """Configurations of pose k, shape (m, n_dof), and which of the ends each comes from, shape (m,)."""
    parent = np.tile(np.arange(len(ends)), _GUESSES)
    away = rng.normal(size=(len(parent), ends.shape[1])) * course.max_step * rng.random((len(parent), 1))
    away[: len(ends)] = 0.0
    q, good = course.near(np.full(len(parent), k), ends[parent] + away)
    good &= np.abs(q - ends[parent]).max(axis=1) <= course.max_step
    good &= ~course.collide(q)
    q, parent = q[good], parent[good]
    _, first = np.unique(np.rint(q / (course.max_step / 2)), axis=0, return_index=True)
    first = np.sort(first)
    first = first[~course.edges_collide(ends[parent[first]], q[first])]
    if len(first) > _MOST:
        first = np.sort(rng.permutation(first)[:_MOST])
    return q[first], parent[first]


def _back(sets: list[Array], parents: list[Counts]) -> Array:
    """The path through the sets, the first left out, to the first configuration of the last."""
    at, rows = 0, []
    for q, parent in zip(sets[:0:-1], parents[:0:-1], strict=True):
        rows.append(q[at])
        at = int(parent[at])
    return np.array(rows[::-1]).reshape(-1, sets[0].shape[1])
