"""Defines the interface of a solver of inverse kinematics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from numpy.typing import ArrayLike

from ulna.ik.query import Query
from ulna.ik.result import IKResult

if TYPE_CHECKING:
    from ulna.collision.world import World


class Solver(Protocol):
    """One way to solve a query. It is made once for a query, then solves any number of targets, from many threads at once."""

    def __init__(self, query: Query) -> None:
        """Prepare what is the same for every target; called only where ``applies`` is true."""
        ...

    @staticmethod
    def applies(query: Query) -> bool:
        """Whether this solver can solve such queries."""
        ...

    def solve(
        self, T: ArrayLike, q_seed: ArrayLike | None, posture: ArrayLike | str | None, held: tuple[str, ...], world: World | None
    ) -> IKResult | None:
        """The result for the targets T, shape (..., 4, 4); None leaves them to the next solver.

        The arguments are those of ``Robot.inverse_kinematics``.

        Raises:
            InputError: An argument that the solver cannot take.
        """
        ...
