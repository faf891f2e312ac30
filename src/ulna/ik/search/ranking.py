"""Computes the cost that ranks solutions, and rejects colliding ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.world import World
from ulna.errors import InputError
from ulna.ik.problem import Problem, Query, mid_range, rows_for
from ulna.kinematics.jacobian import manipulability
from ulna.kinematics.tree import Tree

Array = NDArray[np.float64]


class Costs(NamedTuple):
    """The costs of k solutions, and a mask of the acceptable ones.

    Attributes:
        values: Shape (k,), finite.
        acceptable: Mask of the solutions that do not collide, shape (k,).
    """

    values: Array
    acceptable: NDArray[np.bool_]

    def of_acceptable(self) -> Array:
        """The costs (k,), infinite for unacceptable solutions, so that they are never the minimum."""
        return np.where(self.acceptable, self.values, np.inf)


Cost = Callable[[NDArray[np.int64], Array], Costs]
"""The costs of configurations (k, n_dof) that solve the targets with these indices (k,)."""


def refuse_clearance_of_nothing(rank: str | None, world: World | None) -> None:
    """Raise an error for a rank by clearance without a world."""
    if rank == "clearance" and world is None:
        raise InputError("rank", "'clearance' is the distance from a world, so world= is needed too")


def collisions_of(query: Query, world: World | None) -> CollisionFilter | None:
    """The filter that rejects colliding configurations; None without a world."""
    return None if world is None else CollisionFilter(query.checker, world)


def cost_of(problem: Problem, collisions: CollisionFilter | None) -> Cost | None:
    """The cost function of a search; None if any solution is as good as the first."""
    query, rank = problem.query, problem.query.options.rank
    if rank is None and not problem.seeded and collisions is None:
        return None

    def cost_of_solutions(order: NDArray[np.int64], q: Array) -> Costs:
        if rank == "manipulability":
            cost = -manipulability(query.tree, q, query.link)
        elif rank == "mid_range":
            cost = _from_mid_range(query.tree, q)
        elif rank == "clearance" and collisions is not None:
            clearance = collisions.clearance(q)  # infinite without objects: then all are equal
            cost = -np.where(np.isfinite(clearance), clearance, 0.0)
        elif rank == "nearest" or problem.seeded:
            seeds = rows_for(problem.seeds, order)
            cost = np.abs(q - seeds).max(axis=-1)
        else:
            cost = np.zeros(len(q))
        return Costs(cost, np.ones(len(q), dtype=bool) if collisions is None else ~collisions.collides(q))

    return cost_of_solutions


def _from_mid_range(tree: Tree, q: Array) -> Array:
    """The mean square of the positions relative to half of each range (Liegeois 1977); unlimited joints do not count."""
    half = (tree.upper - tree.lower) / 2
    bounded = np.isfinite(half) & (half > 0)
    share = (q - mid_range(tree))[..., bounded] / half[bounded]
    return np.mean(share**2, axis=-1) if bounded.any() else np.zeros(len(q))


@dataclass(frozen=True, eq=False)
class CollisionFilter:
    """A robot's collision checker, and the world to stay clear of."""

    checker: Checker
    world: World

    def collides(self, q: Array) -> NDArray[np.bool_]:
        """Whether configurations (n, n_dof) collide, shape (n,)."""
        return np.asarray(self.checker.in_collision(q, self.world, self_collision=True))

    def clearance(self, q: Array) -> Array:
        """The distance of configurations (n, n_dof) from the world [m], shape (n,), without self-distances."""
        return self.checker.signed_distance(q, self.world, self_collision=False)

    def pairs(self, q: Array) -> tuple[tuple[str, str], ...]:
        """The names of the pairs that collide at one configuration."""
        report = self.checker.check_collision(q, self.world, self_collision=True, max_distance=0.0)
        return tuple((pair.name_a, pair.name_b) for pair in report.pairs)
