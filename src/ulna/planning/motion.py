"""Holds what a plan was found with, so that more can be asked of it."""

from functools import lru_cache
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ulna.collision.checker import Checker
from ulna.collision.object_tables import NO_OBJECTS
from ulna.collision.objects import Objects
from ulna.collision.world import World
from ulna.kernels.collision.scene import Scene
from ulna.kernels.planning import planning_layout as layout
from ulna.planning.search import Edges, confirmed
from ulna.planning.slices import Pace
from ulna.planning.space import Space

Array = NDArray[np.float64]
RANGE = 1.0  # the longest edge of a tree [rad], for up to _FEW joints
_FEW = 8  # of more joints most samples are far from every node, and fewer long edges are free: no domains, and shorter edges
RESOLUTION = 1e-4  # [m]
SAMPLES_APART = 1 / 32  # [rad]: of an edge that is not certified
_DOMAIN, _LEAST_DOMAIN, _ADAPTATION = 4.0, 1.0, 1e-4  # times RANGE, for up to seven joints; and the rate
_MOST_STEPS = 4096  # of one iteration


class Motion(NamedTuple):
    """What a plan was found with.

    Attributes:
        space: What may be moved, and how lengths are measured.
        checker: The robot's.
        world: A copy of the world as it was.
        margin: How near an object may be [m].
    """

    space: Space
    checker: Checker
    world: World | None
    margin: float

    def is_free(self, points: Array, spreads: Array) -> bool:
        """Whether all within ``spreads``, shape (n - 1, n_dof), of the edges of a path, shape (n, n_dof), is certainly free."""
        edges = edges_of(self.checker, self.world, self.space, self.margin, certify=True)
        return confirmed(edges, points, spreads)[0] is not None

    def clearance(self, q: Array) -> float:
        """The least distance of the robot at q, shape (n, n_dof), from an object [m]; infinite if there is none."""
        if self.world is None or not self.world.names:
            return np.inf
        return float(np.min(self.checker.signed_distance(q, self.world, self_collision=False)))


def edges_of(checker: Checker, world: World | None, space: Space, margin: float, *, certify: bool) -> Edges:
    """What it takes to decide whether an edge is free."""
    objects, kept = NO_OBJECTS if world is None else world.objects(), _kept.get(checker)
    if kept is None or kept[0] is not objects:
        kept = _kept[checker] = objects, checker.scene_of(world, self_collision=True), Pace()
    return Edges(kept[1], _settings(space.n_moving, space.diameter, margin, certify=certify), space, kept[2])


_kept: WeakKeyDictionary[Checker, tuple[Objects, Scene, Pace]] = WeakKeyDictionary()  # of a robot's last world


@lru_cache(maxsize=64)
def _settings(n_moving: int, diameter: float, margin: float, *, certify: bool) -> Array:
    """``planning_layout``'s settings, which are only read."""
    settings = np.zeros(layout.N_SETTINGS)
    longest = RANGE * min(1.0, _FEW / max(1, n_moving))
    settings[layout.RANGE], settings[layout.RESOLUTION], settings[layout.MARGIN] = longest, RESOLUTION, margin
    settings[layout.SAMPLED] = 0.0 if certify else SAMPLES_APART
    wide = RANGE * np.sqrt(max(1.0, n_moving / 7))  # as the distances of samples grow
    settings[layout.DOMAIN] = _DOMAIN * wide if n_moving <= _FEW else np.inf
    settings[layout.LEAST_DOMAIN] = _LEAST_DOMAIN * wide
    settings[layout.ADAPTATION] = _ADAPTATION
    settings[layout.ROOM] = min(4 + np.ceil(diameter / longest), _MOST_STEPS)
    return settings
