"""Holds the pairs of bodies that are near each other, as arrays."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.near_pairs import NearPairs
from ulna.errors import count_of
from ulna.kernels.collision.collision_layout import DISTANCE, NORMAL, PAIR_BODY, PAIR_OBJECT, PAIR_OTHER, WITNESS_A, WITNESS_B

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Distances:
    """The m pairs of ``robot.distances``, grouped by configuration q, the nearest pair of each q first.

    Attributes:
        signed_distance: The distance of each pair [m], shape (m,). A negative value is minus the penetration depth.
        witness_a: The point of a that is nearest to b, or deepest in b, in the base frame [m], shape (m, 3).
        witness_b: The same for b: witness_b - witness_a = signed_distance * normal.
        normal: The unit vector from a to b of minimum distance or overlap, in the base frame, shape (m, 3).
        gradient: The derivative of the signed distance with respect to q [m/rad or m/m], shape (m, n_dof).
        offsets: The pairs of row i of a batch of n are ``offsets[i]`` to before ``offsets[i + 1]``, shape (n + 1,). A batch with
            more axes is flattened in C order; one q is a batch of one row.
    """

    signed_distance: Array
    witness_a: Array
    witness_b: Array
    normal: Array
    gradient: Array
    offsets: NDArray[np.int64]
    _pairs: NDArray[np.int64] = field(repr=False)
    _bodies: Bodies = field(repr=False)
    _object_names: list[str] = field(repr=False)

    def __len__(self) -> int:
        return len(self.signed_distance)

    @cached_property
    def row(self) -> NDArray[np.int64]:
        """The row of the batch that each pair belongs to, shape (m,)."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))

    @property
    def body_a(self) -> NDArray[np.int64]:
        """The index of the robot's body in ``robot.collision_names``, shape (m,)."""
        return self._pairs[:, PAIR_BODY]

    @cached_property
    def body_b(self) -> NDArray[np.int64]:
        """The index of the robot's other body, shape (m,); -1 for an object of the world."""
        return np.where(self._pairs[:, PAIR_OBJECT] < 0, self._pairs[:, PAIR_OTHER], -1)

    @cached_property
    def name_a(self) -> tuple[str, ...]:
        """The m names of the robot's bodies, as in ``Pair.name_a``."""
        return tuple(self._bodies.names[k] for k in self.body_a.tolist())

    @cached_property
    def name_b(self) -> tuple[str, ...]:
        """The m names of the robot's other bodies, or of the objects of the world."""
        numbers, names = self._pairs[:, PAIR_OBJECT].tolist(), self._bodies.names
        return tuple(
            names[k] if number < 0 else self._object_names[number]
            for k, number in zip(self.body_b.tolist(), numbers, strict=True)
        )

    def __repr__(self) -> str:
        n = len(self.offsets) - 1
        nearest = f", the nearest {self.signed_distance.min():.4f} m apart" if len(self) else ""
        return f"<Distances: {count_of(len(self), 'pair')}{f' of {n} configurations' * (n != 1)}{nearest}>"


def distances_of(found: NearPairs, bodies: Bodies, object_names: list[str]) -> Distances:
    """The ``Distances`` of near pairs. ``object_names`` lists names by object number."""
    out = found.contacts
    offsets = np.zeros(len(found.ends) + 1, np.int64)
    offsets[1:] = found.ends
    return Distances(
        out[:, DISTANCE],
        out[:, WITNESS_A:WITNESS_B],
        out[:, WITNESS_B:NORMAL],
        out[:, NORMAL:],
        found.gradients,
        offsets,
        found.pairs,
        bodies,
        object_names,
    )
