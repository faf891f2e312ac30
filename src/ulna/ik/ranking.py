"""Which of several solutions to take: the price of a configuration, by what the caller prefers and what may not be hit."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ulna.errors import InputError, did_you_mean
from ulna.ik.collision_filter import Obstacles
from ulna.ik.problem import Problem, mid_range
from ulna.kinematics.jacobian import manipulability

Array = NDArray[np.float64]
RANKS = ("nearest", "manipulability", "clearance", "mid_range")


def cost_of(
    problem: Problem,
    rank: str | None,
    obstacles: Obstacles | None,
) -> Callable[[NDArray[np.int64], Array], Array] | None:
    """The price function of a search; None if the first solution is as good as any."""
    if rank is None and not problem.seeded and obstacles is None:
        return None
    if rank is not None and rank not in RANKS:
        raise InputError("rank", f"{rank!r} is not a rank{did_you_mean(str(rank), RANKS)}")
    if rank == "clearance" and obstacles is None:
        raise InputError("rank", "'clearance' is the distance from a world, so world= is needed too")

    def price(order: NDArray[np.int64], q: Array) -> Array:
        if rank == "manipulability":
            cost = -manipulability(problem.tree, q, problem.link, threads=problem.threads)
        elif rank == "mid_range":
            cost = _from_mid_range(problem, q)
        elif rank == "clearance" and obstacles is not None:
            cost = -obstacles.clearance(q)
        elif rank == "nearest" or problem.seeded:
            seeds = problem.seeds[np.minimum(order, len(problem.seeds) - 1)]
            cost = np.abs(q - seeds).max(axis=-1)
        else:
            cost = np.zeros(len(q))
        return cost if obstacles is None else np.where(obstacles.collides(q), np.inf, cost)

    return price


def _from_mid_range(problem: Problem, q: Array) -> Array:
    """The mean square of the way from the middle of each range to its ends (Liegeois 1977); no limits do not count."""
    half = (problem.tree.upper - problem.tree.lower) / 2
    bounded = np.isfinite(half) & (half > 0)
    share = (q - mid_range(problem.tree))[..., bounded] / half[bounded]
    return np.mean(share**2, axis=-1) if bounded.any() else np.zeros(len(q))
