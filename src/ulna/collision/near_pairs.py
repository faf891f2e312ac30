"""Finds the pairs that overlap at q, or are near each other, and makes reports of them."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ulna.collision.bodies import Bodies
from ulna.collision.bound_scene import BoundScene
from ulna.collision.entries import contacts
from ulna.collision.objects import Objects
from ulna.collision.report import Pair, Report
from ulna.description.arrays import as_number
from ulna.engine.threads import in_parts
from ulna.kernels.collision.collision_layout import CONTACT_WIDTH, DISTANCE, NORMAL, PAIR_WIDTH, WITNESS_A, WITNESS_B
from ulna.kernels.collision.scene import NearPairs
from ulna.kinematics.positions import flat, for_kernel, refuse_out_of_range

Array = NDArray[np.float64]
FIRST_ROOM, ROOM_OF_ONE = 32, 32  # pairs: initial room of any batch, and of each q; a full search is repeated with more room
MIN_ROWS = 64  # minimum for a thread


def as_reach(name: str, distance: float) -> float:
    """Validate a maximum distance of pairs [m], which may be infinite.

    Raises:
        InputError: It is not a number of at least 0.
    """
    return as_number(name, distance, 0.0, "a distance [m] of at least 0", most=np.inf)


def find_near_pairs(q: Array, scene: BoundScene, n_objects: int, within: float, *, gradients: bool = False) -> NearPairs:
    """The pairs at most ``within`` [m] apart at each q, shape (..., n_dof).

    n_objects: The number of objects, to keep only the solid of an object that is nearest to each body. With 0 all solids count.

    Raises:
        InputError: An entry of q is out of range.
    """
    rows = q[None] if q.ndim == 1 else flat(q)
    if len(rows) <= MIN_ROWS:
        found = _in_one_part(rows, scene, n_objects, within, gradients=gradients)
    else:
        found = _in_several_parts(rows, scene, n_objects, within, gradients=gradients)
    if found is None:
        refuse_out_of_range(q)
        raise AssertionError("an entry of q is out of range")
    return found


def _in_several_parts(q: Array, scene: BoundScene, n_objects: int, within: float, *, gradients: bool) -> NearPairs | None:
    found: dict[int, NearPairs] = {}

    def run(part: slice) -> bool:
        part_pairs = _in_one_part(q[part], scene, n_objects, within, gradients=gradients)
        if part_pairs is not None:
            found[part.start] = part_pairs
        return part_pairs is not None

    if not in_parts(run, len(q), least=MIN_ROWS):
        return None
    parts = [found[start] for start in sorted(found)]
    n_before = np.cumsum([0, *(len(part.pairs) for part in parts)])
    ends = np.concatenate([part.ends + first for part, first in zip(parts, n_before, strict=False)])
    return NearPairs(ends, *(np.concatenate(arrays) for arrays in list(zip(*parts, strict=True))[1:]))


def _in_one_part(q: Array, scene: BoundScene, n_objects: int, within: float, *, gradients: bool) -> NearPairs | None:
    n, room = len(q), FIRST_ROOM + ROOM_OF_ONE * len(q)
    of_kernel, ends = for_kernel(q), np.empty(n, np.int64)
    while True:
        pairs, rows = np.empty((room, PAIR_WIDTH), np.int64), np.empty((room, CONTACT_WIDTH))
        found = NearPairs(ends, pairs, rows, np.empty((room if gradients else 0, q.shape[1])))
        if not scene.bound(contacts.near_each)(n_objects, of_kernel, within, found):
            return None
        count = int(ends[-1]) if n else 0
        if count >= 0:
            return NearPairs(ends, pairs[:count], rows[:count], found.gradients[:count])
        room *= 4


def reports_of(found: NearPairs, bodies: Bodies, objects: Objects) -> Iterator[Report]:
    """A report for each q."""
    names, owners, n, first = bodies.names, bodies.owners, len(bodies.names), 0
    object_names = objects.layout.names
    distances = found.contacts[:, DISTANCE].tolist()
    points = (found.contacts[:, place : place + 3].copy() for place in (WITNESS_A, WITNESS_B, NORMAL))
    pairs = [
        Pair(names[a], names[b], owners[a], owners[b], *rest)
        if b < n
        else Pair(names[a], object_names[number], owners[a], None, *rest, _ball=objects.ball(object_names[number], b - n))
        for (a, b, number), *rest in zip(found.pairs.tolist(), distances, *points, strict=True)
    ]
    for end in found.ends.tolist():
        yield Report(tuple(pairs[first:end]))
        first = end
