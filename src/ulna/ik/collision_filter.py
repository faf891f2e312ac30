"""What a search may not hit: the robot's own collision queries, as the search asks them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ulna.collision.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Obstacles:
    """A world, and the robot (its ``in_collision``, ``signed_distance`` and ``check_collision``) that must stay clear of it."""

    robot: Any
    world: World
    threads: int | None = None

    def collides(self, q: Array) -> NDArray[np.bool_]:
        """Whether configurations (n, n_dof) collide, shape (n,)."""
        return self.robot.in_collision(q, self.world, threads=self.threads)

    def clearance(self, q: Array) -> Array:
        """How far configurations (n, n_dof) are from the world [m], shape (n,): a robot is always near to itself."""
        return self.robot.signed_distance(q, self.world, self_collision=False, threads=self.threads)

    def pairs(self, q: Array) -> tuple[tuple[str, str], ...]:
        """The names of the pairs that collide at one configuration."""
        return tuple((pair.name_a, pair.name_b) for pair in self.robot.check_collision(q, self.world).pairs)
