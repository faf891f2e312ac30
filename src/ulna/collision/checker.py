"""Collision queries: the robot at q against itself and against the objects of a world."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ulna.collision.allowed import AllowedCollisions
from ulna.collision.attached import Attached
from ulna.collision.bodies import Bodies, checked_pairs, make_bodies
from ulna.collision.evidence import find_allowed
from ulna.collision.objects import Objects
from ulna.collision.report import Pair, Report
from ulna.collision.world import World
from ulna.errors import InputError
from ulna.kernels.contacts import CONTACT_WIDTH, DISTANCE, NORMAL, WITNESS_A, WITNESS_B, contacts_one
from ulna.kernels.verdict import OUT_OF_RANGE, OVERLAPS, overlap_batch, overlap_one
from ulna.kinematics.positions import as_positions, flat, for_kernel, refuse_out_of_range
from ulna.model.description import Description
from ulna.model.tree import Tree

NO_OBJECTS = World().objects()
NO_PAIRS = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Checker:
    """Answers the collision queries of one robot.

    Attributes:
        description: The robot.
        tree: The same as arrays.
        attached: What it carries.
        given: The pairs of links that may touch, where the user said so; otherwise they are found when first needed.
    """

    description: Description
    tree: Tree
    attached: tuple[Attached, ...]
    given: AllowedCollisions | None

    @cached_property
    def bodies(self) -> Bodies:
        """The robot's collision bodies, and those of what it carries."""
        return make_bodies(self.description, self.tree, self.attached)

    @cached_property
    def allowed(self) -> AllowedCollisions:
        """The pairs of links that may touch."""
        return find_allowed(self.description, self.tree, self.bodies) if self.given is None else self.given

    @cached_property
    def pairs(self) -> NDArray[np.int64]:
        """The pairs of bodies that may not touch."""
        return checked_pairs(self.bodies, self.tree, self.allowed, self.attached)

    def in_collision(self, q: ArrayLike, world: World | None, self_collision: bool) -> bool | NDArray[np.bool_]:
        """Whether anything touches: a bool for one q, else shape (...,)."""
        objects, pairs = self._asked(world, self_collision)
        q = as_positions(q, self.tree)
        scene = self._scene(pairs, objects)
        if q.ndim == 1:
            answer = overlap_one(*scene, for_kernel(q))
            if answer == OUT_OF_RANGE:
                refuse_out_of_range(q)
            return answer == OVERLAPS
        hits = np.empty(q.shape[:-1], dtype=np.bool_)
        if not overlap_batch(*scene, flat(q), hits.reshape(-1)):
            refuse_out_of_range(q)
        return hits

    def check_collision(self, q: ArrayLike, world: World | None, self_collision: bool) -> Report:
        """Every pair that touches, for one q."""
        objects, pairs = self._asked(world, self_collision)
        q, bodies = as_positions(q, self.tree), self.bodies
        if q.ndim != 1:
            raise InputError("q", f"shape {q.shape}: a report is of one configuration; in_collision() takes a batch")
        n = len(bodies.names)
        against_world = np.stack(np.meshgrid(np.arange(n), n + np.arange(len(objects.names)), indexing="ij"), axis=-1)
        candidates = np.concatenate([against_world.reshape(-1, 2), pairs])
        found = np.empty((len(candidates), CONTACT_WIDTH))
        scene = self.tree.joints, bodies.table, bodies.vertices, objects.table, objects.vertices
        if not contacts_one(*scene, candidates, for_kernel(q), found):
            refuse_out_of_range(q)
        kept = [k for k in np.argsort(found[:, DISTANCE], kind="stable") if found[k, DISTANCE] <= 0.0]
        return Report(tuple(self._pair(candidates[k], found[k], objects.names) for k in kept))

    def _pair(self, candidate: NDArray[np.int64], found: NDArray[np.float64], object_names: tuple[str, ...]) -> Pair:
        (a, b), names, owners = candidate.tolist(), self.bodies.names, self.bodies.owners
        name_b, link_b = (names[b], owners[b]) if b < len(names) else (object_names[b - len(names)], None)
        points = (found[first : first + 3].copy() for first in (WITNESS_A, WITNESS_B, NORMAL))
        return Pair(names[a], name_b, owners[a], link_b, float(found[DISTANCE]), *points)

    def _asked(self, world: World | None, self_collision: bool) -> tuple[Objects, NDArray[np.int64]]:
        if world is None and not self_collision:
            raise InputError("world", "is None and self_collision is False, so there is nothing to check")
        if world is not None and not isinstance(world, World):
            raise InputError("world", f"{type(world).__name__}; an ulna.World is expected")
        return NO_OBJECTS if world is None else world.objects(), self.pairs if self_collision else NO_PAIRS

    def _scene(self, pairs: NDArray[np.int64], objects: Objects) -> tuple:
        """The robot and the world, as the kernels take them."""
        robot, bodies = self.tree.joints, self.bodies
        return robot, bodies.table, bodies.vertices, pairs, objects.table, objects.vertices, objects.nodes, objects.n_alone
