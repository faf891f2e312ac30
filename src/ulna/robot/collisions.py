"""What a robot touches: the world, or itself."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions
from ulna.collision.attached import Attached
from ulna.collision.world import World
from ulna.robot.kinematics import Kinematics

if TYPE_CHECKING:
    from ulna.collision.checker import Checker
    from ulna.collision.edge_report import EdgeReport

Array = NDArray[np.float64]


class Collisions(Kinematics):
    """Collision queries and distances."""

    attached: tuple[Attached, ...]
    """What the robot carries."""
    _allowed: AllowedCollisions | None

    def in_collision(
        self, q: ArrayLike, world: World | None = None, self_collision: bool = True, *, out: NDArray[np.bool_] | None = None
    ) -> bool | NDArray[np.bool_]:
        """Whether any of the robot's shapes touches, overlaps, contains or lies within an object of the world, or another link.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            out: Written to and returned if given: a bool array of the result's shape.

        Returns:
            A bool for one q, else shape (...,).

        Raises:
            GeometryError: The robot has no collision shapes, or some that cannot be checked.
        """
        return self._checker.in_collision(q, world, self_collision, out)

    def check_collision(
        self, q: ArrayLike, world: World | None = None, self_collision: bool = True, *, max_distance: float = 0.0
    ) -> Any:
        """Which of the robot's shapes overlap which objects, or each other, how deep and where.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            max_distance: Tell of pairs too that are apart, but no farther than this [m]; ``np.inf`` tells of all.

        Returns:
            A ``Report`` for one q, else an array of them, shape (...,).
        """
        return self._checker.check_collision(q, world, self_collision, max_distance)

    def signed_distance(
        self, q: ArrayLike, world: World | None = None, self_collision: bool = True, *, out: Array | None = None
    ) -> Any:
        """The least distance of the robot's shapes from an object, or from another link [m]; negative: how deep they overlap.

        Zero where shapes touch: ``signed_distance(q) <= 0`` is what ``in_collision(q)`` says.

        Args:
            q: Joint positions [rad or m], shape (..., n_dof).
            world: The objects; none unless given.
            self_collision: Whether to measure between the robot's links too, but for ``allowed_collisions``.
            out: Written to and returned if given: a float64 array of the result's shape.

        Returns:
            A number for one q, else shape (...,); infinite where there is nothing to measure to.
        """
        return self._checker.signed_distance(q, world, self_collision, out)

    def distance_gradient(
        self, q: ArrayLike, world: World | None = None, self_collision: bool = True, *, out: Array | None = None
    ) -> Array:
        """The derivative of ``signed_distance`` by q [m/rad or m/m], shape (..., n_dof).

        Where two pairs are equally near, or a pair has several nearest points, it is the derivative of one of them; zero where
        there is nothing to measure to. The arguments are those of ``signed_distance``.
        """
        return self._checker.distance_gradient(q, world, self_collision, out)

    def edge_in_collision(
        self,
        q_a: ArrayLike,
        q_b: ArrayLike,
        world: World | None = None,
        self_collision: bool = True,
        *,
        resolution: float = 1e-4,
    ) -> EdgeReport:
        """Whether anything touches on the straight line from one configuration to another: free is free for all of the line.

        That rests on lower bounds of distances, with their rounding, and not on samples (docs/edges.md).

        Args:
            q_a: Joint positions at the start [rad or m], shape (..., n_dof).
            q_b: Joint positions at the end, of a shape that goes with the other. Joints move evenly; none takes a shorter way.
            world: The objects; none unless given.
            self_collision: Whether to check the robot's links against each other too, but for ``allowed_collisions``.
            resolution: A clearance below this [m] may count as a contact; none above does.

        Returns:
            An ``EdgeReport``: in_collision, and how far on the way all is free.
        """
        return self._checker.edge_in_collision(q_a, q_b, world, self_collision, resolution)

    @property
    def allowed_collisions(self) -> AllowedCollisions:
        """The pairs of links that may touch, each with its reason: found from joints and samples unless the user gave others."""
        return self._checker.allowed

    def collision_poses(self, q: ArrayLike, *, out: Array | None = None) -> Array:
        """The poses of the robot's collision shapes, in the order of ``collision_names``: shape (..., n_shapes, 4, 4)."""
        return self._forward.frame_poses(self.tree, self._checker.bodies.table, q, out)

    @property
    def collision_names(self) -> tuple[str, ...]:
        """The names of the robot's collision shapes, attached objects last."""
        return self._checker.bodies.names

    @cached_property
    def _checker(self) -> Checker:
        from ulna.collision.checker import Checker

        return Checker(self.description, self.tree, self.attached, self._allowed)
