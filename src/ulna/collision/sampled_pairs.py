"""Finds pairs of links that may touch, from joints and random configurations.

To save time, MoveIt's setup assistant also allows the pairs that never touched in its samples (Coleman et al.). Here such pairs
are checked: samples without contact prove nothing, and a pair costs a few nanoseconds.

Source: Coleman et al., Reducing the barrier to entry of complex robotic software, J. Software Engineering for Robotics 5(1),
2014, section 4.1.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ulna.collision.allowed import ADJACENT, ALWAYS, FIXED, NEVER, SOMETIMES, AllowedCollisions, LinkPair, as_link_pairs
from ulna.collision.bodies import NO_PAIRS, Bodies, scene_of
from ulna.collision.entries import overlap
from ulna.collision.object_tables import NO_OBJECTS
from ulna.description.robot_description import Description
from ulna.kernels.collision.collision_layout import OVERLAPS
from ulna.kernels.collision.scene import Scene
from ulna.kinematics.positions import for_kernel
from ulna.kinematics.sample import random_positions
from ulna.kinematics.tree import Tree

SAMPLES, SEED = 2000, 0


class SampledPairs:
    """The pairs of links of a robot that may touch, found at their first use.

    These are links joined by one joint, links without a joint between them, and links that touch in all samples. Robots that
    differ only in their attached objects share one instance.
    """

    def __init__(self, description: Description, tree: Tree) -> None:
        """Take the links of a robot."""
        self._description, self._tree = description, tree
        self._with_counts: AllowedCollisions | None = None
        self._without_counts: AllowedCollisions | None = None

    def with_counts(self, bodies: Bodies) -> AllowedCollisions:
        """The allowed and the checked pairs, each with its number of contacts in SAMPLES random configurations."""
        if self._with_counts is None:
            allowed, open_pairs = self._split_by_joints()
            q, in_contact = random_positions(self._tree, SAMPLES, SEED), np.empty(SAMPLES, np.bool_)
            checked = []
            for links, pair_scene in self._pair_scenes(bodies, open_pairs):
                overlap.overlap_batch(pair_scene, for_kernel(q), in_contact)
                pair = _make_pair(*links, in_contact, q)
                (allowed if pair.reason == ALWAYS else checked).append(pair)
            self._with_counts = self._with_srdf(allowed, tuple(checked))
        return self._with_counts

    def without_counts(self, bodies: Bodies) -> AllowedCollisions:
        """The allowed pairs without counts, which takes less time: most other pairs are free in one of the first samples.

        It calls the entry for one q, which compiles in a second or two, and which other calls need anyway.
        """
        if self._with_counts is not None:
            return self._with_counts
        if self._without_counts is None:
            allowed, open_pairs = self._split_by_joints()
            q = for_kernel(random_positions(self._tree, SAMPLES, SEED))
            for links, pair_scene in self._pair_scenes(bodies, open_pairs):
                if all(overlap.overlap_one(pair_scene, row) == OVERLAPS for row in q):
                    allowed.append(LinkPair(*links, ALWAYS))
            self._without_counts = self._with_srdf(allowed)
        return self._without_counts

    def _pair_scenes(self, bodies: Bodies, link_pairs: list[tuple[str, str]]) -> Iterator[tuple[tuple[str, str], Scene]]:
        """Each pair of links with a scene in which only these two are checked."""
        itself = scene_of(self._tree.joints, bodies, NO_PAIRS, NO_OBJECTS)
        for links in link_pairs:
            yield links, itself._replace(pairs=bodies.table_of_pairs([links]))

    def _split_by_joints(self) -> tuple[list[LinkPair], list[tuple[str, str]]]:
        """Split the pairs of links with shapes into those allowed by their joints, and all others."""
        carriers = [link.name for link in self._description.links if link.collisions]
        joined = {frozenset((joint.parent, joint.child)) for joint in self._description.joints}
        allowed, open_pairs = [], []
        for a, b in combinations(carriers, 2):
            if self._tree.link_row[a] == self._tree.link_row[b]:
                allowed.append(LinkPair(a, b, FIXED))
            elif {a, b} in joined:
                allowed.append(LinkPair(a, b, ADJACENT))
            else:
                open_pairs.append((a, b))
        return allowed, open_pairs

    def _with_srdf(self, allowed: list[LinkPair], checked: tuple[LinkPair, ...] = ()) -> AllowedCollisions:
        return AllowedCollisions(tuple(allowed), checked).plus(*as_link_pairs(self._description.srdf.disabled_collisions))


def _make_pair(a: str, b: str, in_contact: NDArray[np.bool_], q: NDArray[np.float64]) -> LinkPair:
    count = int(np.count_nonzero(in_contact))
    reason = NEVER if count == 0 else ALWAYS if count == len(in_contact) else SOMETIMES
    return LinkPair(a, b, reason, count, len(in_contact), tuple(q[int(np.argmax(in_contact))].tolist()))
