"""Holds the results of collision checks: pairs at a configuration, and the free part of an edge."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ulna.collision.clouds import PointCloud
from ulna.collision.object_tree import compact_order
from ulna.errors import TruthError, count_of
from ulna.notebook.tables import OneLine, table


@dataclass(frozen=True, eq=False, repr=False)
class Pair(OneLine):
    """Two shapes and their signed distance.

    Attributes:
        name_a: The robot's shape.
        name_b: Another shape of the robot, or the object of the world.
        link_a: The link of ``name_a``, or its own name if it is an attached object.
        link_b: The same for ``name_b``; None for an object of the world.
        signed_distance: Their distance [m]. A negative value is minus the penetration depth. The depth is never underestimated.
            For a cylinder, and for two meshes of many hundred vertices each, it may be an upper bound (docs/conventions.md says
            how close).
        witness_a: The point of a that is nearest to b, or deepest in b, in the base frame [m], shape (3,).
        witness_b: The same for b: witness_b - witness_a = signed_distance * normal.
        normal: The unit vector from a to b of minimum distance or overlap, in the base frame, shape (3,).
    """

    name_a: str
    name_b: str
    link_a: str
    link_b: str | None
    signed_distance: float
    witness_a: NDArray[np.float64]
    witness_b: NDArray[np.float64]
    normal: NDArray[np.float64]
    _ball: tuple[PointCloud, int] | None = field(default=None, repr=False)

    @cached_property
    def point(self) -> int | None:
        """The index in the cloud's ``points`` of the center of b; None if b is no point of a cloud.

        The center is ``witness_b + radius * normal``. The index is computed at its first use, in a millisecond or two among 10^5
        points.
        """
        if self._ball is None:
            return None
        cloud, place = self._ball
        return int(compact_order(cloud.points)[place])

    def __getstate__(self) -> dict[str, Any]:
        """The state without the cloud, which may be large."""
        return {**self.__dict__, "point": self.point, "_ball": None}

    def __str__(self) -> str:
        far = 1e3 * self.signed_distance
        return f"{self.name_a} is {abs(far):.4g} mm {'from' if far > 0.0 else 'deep in'} {self.name_b}"


@dataclass(frozen=True, eq=False, repr=False)
class Report(OneLine):
    """The pairs that overlap, deepest first, then those within ``max_distance``.

    ``bool(report)`` is True if any pair overlaps.
    """

    pairs: tuple[Pair, ...]

    def __bool__(self) -> bool:
        return self.in_collision

    @property
    def in_collision(self) -> bool:
        """True if any pair overlaps."""
        return bool(self.pairs) and self.pairs[0].signed_distance <= 0.0

    @property
    def touching(self) -> tuple[str, ...]:
        """The sorted names of the robot's shapes that overlap anything."""
        overlapping = [pair for pair in self.pairs if pair.signed_distance <= 0.0]
        names = [pair.name_a for pair in overlapping] + [pair.name_b for pair in overlapping if pair.link_b is not None]
        return tuple(sorted(dict.fromkeys(names), key=_natural))

    def _repr_html_(self) -> str:
        rows = [(pair.name_a, pair.name_b, 1e3 * pair.signed_distance) for pair in self.pairs]
        return table(repr(self)[1:-1], ("shape", "and", "distance [mm]"), rows)

    def __str__(self) -> str:
        return f"collision: {', '.join(self.touching)}" if self.in_collision else "free"

    def __repr__(self) -> str:
        n = len(self.pairs)
        deepest = f", {self.pairs[0]}" if n else ""
        return f"<Report: {self}; {n} pair{'s' * (n != 1)}{deepest}>"


@dataclass(frozen=True, eq=False, repr=False)
class EdgeReport(OneLine):
    """Whether the robot touches anything from q_a to q_b. A report of one edge is also a bool.

    Attributes:
        in_collision: True if it does: a bool for one edge, else shape (...,).
        free_until: The fraction of the line, in [0, 1], that is certainly free; 1 if all of it is free. If ``in_collision``, the
            robot there touches something, or is within the resolution of it.
        q: The configuration at ``free_until`` [rad or m], shape (..., n_dof).
    """

    in_collision: Any
    free_until: Any
    q: NDArray[np.float64]

    def __bool__(self) -> bool:
        if np.ndim(self.in_collision):
            raise TruthError("an EdgeReport", "report.in_collision")
        return bool(self.in_collision)

    def __str__(self) -> str:
        if np.ndim(self.in_collision):
            return f"{np.count_nonzero(self.in_collision)} of {count_of(np.size(self.in_collision), 'edge')} in collision"
        return f"collision at {self.free_until:.4f} of the edge" if self.in_collision else "free"


def _natural(name: str) -> tuple:
    """A sort key with "box 7" before "box 12"."""
    return tuple((0, int(word), "") if word.isdigit() else (1, 0, word) for word in name.split())
