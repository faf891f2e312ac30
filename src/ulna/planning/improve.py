"""Goes on with a plan for a shorter path.

AORRTC (Wilson, Thomason, Kingston and Gammell, RA-L 2025): searches for a path that is shorter than the best one, one after the
other, each with new trees and other samples. What a search finds is shortened, and its length bounds the next search.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.planning.motion import Motion
from ulna.planning.plan_status import Effort
from ulna.planning.search import Search
from ulna.planning.slices import TimeLimit

Array = NDArray[np.float64]
_WORTH = 1e-4  # of the length: a path is to be shorter by more
_FIRST_CHECKS = 256  # of a search, until one has failed


class Searched(NamedTuple):
    """What was searched for, so that the search can go on.

    Attributes:
        motion: What may be moved, the robot and the world.
        start: Where the certified part of the path begins, shape (n_dof,).
        goals: Shape (n, n_dof).
        of: Which of the given goals each of them is, shape (n,).
        certify: Whether edges are certified.
        seed: That of the plan.
        n_searches: How many searches there were.
    """

    motion: Motion
    start: Array
    goals: Array
    of: NDArray[np.int64]
    certify: bool
    seed: int
    n_searches: int = 1


class Best(NamedTuple):
    """The shortest path that was found.

    Attributes:
        path: From ``Searched.start`` to a goal, shape (n, n_dof).
        goal: Which of the given goals it reaches.
        certified: Whether all of its edges are certified.
        effort: What all searches took.
    """

    path: Array
    goal: int
    certified: bool
    effort: Effort


def improved(searched: Searched, best: Best, max_checks: int, time_limit: float | None) -> tuple[Searched, Best]:
    """A shorter path, or the same if none was found, after at most so many more checks; see ``Plan.improve``."""
    motion, limit = searched.motion, TimeLimit(time_limit)
    space, (path, goal, certified, effort) = motion.space, best
    edges = motion.edges(certify=searched.certify)
    straight = space.lengths(space.shortest_way(searched.goals - searched.start)).min()
    most, n_searches = effort.checks + max_checks, searched.n_searches
    budget = _FIRST_CHECKS
    while effort.checks < most:
        length = space.lengths(np.diff(path, axis=0)).sum()
        if length * (1.0 - _WORTH) <= straight or limit.is_over():
            break
        search = Search(edges, searched.start, searched.goals, (searched.seed, n_searches), length * (1.0 - _WORTH))
        found, n_searches = search.finish(min(budget, most - effort.checks), limit, shorten=True), n_searches + 1
        effort = effort.plus(search.effort)
        if found is None:
            budget *= 2  # not all at once: a small tree costs less, and other samples may do better
        elif found.confirmed and space.lengths(np.diff(found.path, axis=0)).sum() < length:
            path, goal, certified = found.path, int(searched.of[search.goal]), searched.certify
    return searched._replace(n_searches=n_searches), Best(path, goal, certified, effort)
