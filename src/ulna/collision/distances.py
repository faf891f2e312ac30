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
    """The m pairs of ``robot.distances``: those of one q after those of the one before, the nearest of each q first.

    Attributes:
        signed_distance: The distance of each pair [m], shape (m,); negative: minus the penetration depth.
        witness_a: The point of a that lies deepest in b, or nearest to it, in the base frame [m], shape (m, 3).
        witness_b: The same of b: witness_b - witness_a = signed_distance * normal.
        normal: The unit vector from a to b along which they are nearest, or overlap least, in the base frame, shape (m, 3).
        gradient: The derivative of the signed distance by q [m/rad or m/m], shape (m, n_dof).
        offsets: The pairs of row i of a batch of n are those from ``offsets[i]`` to before ``offsets[i + 1]``, shape (n + 1,). A
            batch of more axes is counted in C order; one q is a batch of one row.
    """

    signed_distance: Array
    witness_a: Array
    witness_b: Array
    normal: Array
    gradient: Array
    offsets: NDArray[np.int64]
    _found: NDArray[np.int64] = field(repr=False)
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
        """The robot's body, an index of ``robot.collision_names``, shape (m,)."""
        return self._found[:, PAIR_BODY]

    @cached_property
    def body_b(self) -> NDArray[np.int64]:
        """Its other body; -1 where the pair is with an object of the world, shape (m,)."""
        return np.where(self._found[:, PAIR_OBJECT] < 0, self._found[:, PAIR_OTHER], -1)

    @cached_property
    def name_a(self) -> tuple[str, ...]:
        """The names of the robot's bodies, as ``Pair.name_a`` has them, m of them."""
        return tuple(self._bodies.names[k] for k in self.body_a.tolist())

    @cached_property
    def name_b(self) -> tuple[str, ...]:
        """Those of the other bodies, or of the objects of the world."""
        numbers, names = self._found[:, PAIR_OBJECT].tolist(), self._bodies.names
        return tuple(
            names[k] if number < 0 else self._object_names[number]
            for k, number in zip(self.body_b.tolist(), numbers, strict=True)
        )

    def __repr__(self) -> str:
        n = len(self.offsets) - 1
        nearest = f", the nearest {self.signed_distance.min():.4f} m apart" if len(self) else ""
        return f"<Distances: {count_of(len(self), 'pair')}{f' of {n} configurations' * (n != 1)}{nearest}>"


def distances_of(found: NearPairs, bodies: Bodies, object_names: list[str]) -> Distances:
    """As the user gets them; object_names: by the numbers of the objects."""
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
