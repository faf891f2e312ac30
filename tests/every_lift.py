"""Finds the best joint path of a six-joint arm by brute force, over all solutions with all whole turns."""

import itertools

import numpy as np

from ulna import Robot

TURN = 2 * np.pi
_TURNS = np.arange(-3, 4)
_ROUNDING = 1e-9


def lifts_of(q, lower, upper):
    """All configurations within the limits that differ from q (n_dof,) by whole turns, shape (m, n_dof)."""
    turned = [angle + TURN * _TURNS for angle in q]
    within = [x[(x >= low - _ROUNDING) & (x <= high + _ROUNDING)] for x, low, high in zip(turned, lower, upper, strict=True)]
    return np.array(list(itertools.product(*within))).reshape(-1, len(q)).clip(lower, upper)


def nodes_of(rows, limits, T):
    """Of each pose the solutions within the limits; rows: the table of the arm. The arm without limits in between gives them."""
    lower, upper = np.array(limits).T
    found = Robot.from_dh(rows, convention="standard", limits=[(-np.pi, np.pi)] * len(rows)).all_solutions(T)
    assert np.isin(found.proof, ["complete", "complete but for coinciding branches"]).all()
    return [
        np.vstack([lifts_of(q, lower, upper) for q in row[real]] or [np.empty((0, len(lower)))])
        for row, real in zip(found.q, found.real, strict=True)
    ]


def least_costs(nodes, max_step, start=None):
    """The least sums of squared steps of paths to each pose, from the start on, infinite where there is none, shape (n,)."""
    cost = np.zeros(len(nodes[0]))
    if start is not None:
        cost = ((nodes[0] - start) ** 2).sum(axis=1)
        cost[np.abs(nodes[0] - start).max(axis=1, initial=0.0) > max_step + _ROUNDING] = np.inf
    least = [cost.min(initial=np.inf)]
    for a, b in itertools.pairwise(nodes):
        steps = b[:, None] - a
        sums = np.where(np.abs(steps).max(axis=2, initial=0.0) <= max_step + _ROUNDING, (steps**2).sum(axis=2) + cost, np.inf)
        cost = sums.min(axis=1, initial=np.inf)
        least.append(cost.min(initial=np.inf))
    return np.array(least)
