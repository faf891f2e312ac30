"""Rejects configurations that collide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CollisionFilter:
    """A robot's collision checker, and the world that the robot must stay clear of."""

    checker: Checker
    world: World
    threads: int | None = None

    def collides(self, q: Array) -> NDArray[np.bool_]:
        """Whether configurations (n, n_dof) collide, shape (n,)."""
        return np.asarray(self.checker.in_collision(q, self.world, self_collision=True, threads=self.threads))

    def clearance(self, q: Array) -> Array:
        """How far configurations (n, n_dof) are from the world [m], shape (n,), the distances within the robot left out."""
        return self.checker.signed_distance(q, self.world, self_collision=False, threads=self.threads)

    def pairs(self, q: Array) -> tuple[tuple[str, str], ...]:
        """The names of the pairs that collide at one configuration."""
        report = self.checker.check_collision(q, self.world, self_collision=True, max_distance=0.0)
        return tuple((pair.name_a, pair.name_b) for pair in report.pairs)
