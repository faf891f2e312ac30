"""Goes on with a plan for a shorter path. Used by ``plan``.

AORRTC (Wilson, Thomason, Kingston and Gammell, RA-L 2025): searches for a path that is shorter than the best one, one after the
other, each with new trees and other samples. What a search finds is shortened, and its length bounds the next search.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError
from ulna.planning.motion import Motion, edges_of
from ulna.planning.options import refuse_unless, refuse_unless_count
from ulna.planning.search import Search

if TYPE_CHECKING:
    from ulna.planning.plan import Plan

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


def improved(plan: Plan, searched: Searched | None, max_checks: int, time_limit: float | None) -> Plan:
    """A plan with a shorter path, or the same if none was found; see ``Plan.improve``.

    Raises:
        InputError: There is no path, or ``max_checks`` or ``time_limit`` cannot be taken.
    """
    refuse_unless_count("max_checks", max_checks, 1)
    if time_limit is not None:
        refuse_unless("time_limit", time_limit, 0.0, "a time [s] above 0", above=True)
    if searched is None or not plan:
        raise InputError("plan", f"there is no path: {plan.status}")
    began, motion, effort = time.perf_counter(), searched.motion, plan.effort
    space = motion.space
    edges = edges_of(motion.checker, motion.world, space, motion.margin, certify=searched.certify)
    outside = plan.path[:1] if plan.escaped else plan.path[:0]  # the edge that leads out of a contact stays
    path, goal, certified = plan.path[len(outside) :], plan.goal, plan.certified
    straight = space.lengths(space.shortest_way(searched.goals - searched.start)).min()
    most, n_searches = effort.checks + int(max_checks), searched.n_searches
    budget = _FIRST_CHECKS
    while effort.checks < most:
        length, left = space.lengths(np.diff(path, axis=0)).sum(), None
        if time_limit is not None:
            left = time_limit - (time.perf_counter() - began)
        if length * (1.0 - _WORTH) <= straight or (left is not None and left <= 0.0):
            break
        search = Search(edges, searched.start, searched.goals, (searched.seed, n_searches), length * (1.0 - _WORTH))
        found, n_searches = search.finish(min(budget, most - effort.checks), left, shorten=True), n_searches + 1
        effort = effort.plus(search.effort)
        if found is None:
            budget *= 2  # not all at once: a small tree costs less, and other samples may do better
        elif found.confirmed and space.lengths(np.diff(found.path, axis=0)).sum() < length:
            path, goal, certified = found.path, int(searched.of[search.goal]), searched.certify
    return replace(
        plan,
        path=np.concatenate([outside, path]),
        certified=certified,
        effort=effort,
        goal=goal,
        _searched=searched._replace(n_searches=n_searches),
    )
