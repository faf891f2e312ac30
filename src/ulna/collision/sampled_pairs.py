"""Finds pairs of links that may touch, from joints and random configurations. Used by ``checker``.

To save time, MoveIt's setup assistant also allows the pairs that never touched in its samples (Coleman et al., Reducing the
barrier to entry of complex robotic software, J. Software Engineering for Robotics 5(1), 2014, section 4.1). Here such
pairs are checked: samples without contact do not prove that there is none, and a pair costs a few nanoseconds.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ulna.collision.allowed import ADJACENT, ALWAYS, FIXED, NEVER, SOMETIMES, AllowedCollisions, LinkPair
from ulna.collision.bodies import Bodies
from ulna.description.robot_description import Description
from ulna.drivers import entry
from ulna.kinematics.positions import for_kernel
from ulna.kinematics.sample import random_positions
from ulna.kinematics.tree import Tree

SAMPLES, SEED = 2000, 0


def find_allowed(description: Description, tree: Tree, bodies: Bodies) -> AllowedCollisions:
    """Allows links joined by one joint, links that do not move relative to each other, and links that always touch."""
    carriers = [link.name for link in description.links if link.collisions]
    joined = {frozenset((joint.parent, joint.child)) for joint in description.joints}
    allowed, open_pairs = [], []
    for a, b in combinations(carriers, 2):
        if tree.link_row[a] == tree.link_row[b]:
            allowed.append(LinkPair(a, b, FIXED))
        elif {a, b} in joined:
            allowed.append(LinkPair(a, b, ADJACENT))
        else:
            open_pairs.append((a, b))
    seen = sampled(tree, bodies, open_pairs)
    allowed += [pair for pair in seen if pair.reason == ALWAYS]
    return AllowedCollisions(tuple(allowed), tuple(pair for pair in seen if pair.reason != ALWAYS))


def sampled(tree: Tree, bodies: Bodies, link_pairs: list[tuple[str, str]]) -> list[LinkPair]:
    """Counts the contacts of each pair of links in SAMPLES random configurations, which are the same in every run."""
    if not link_pairs:
        return []
    q = random_positions(tree, SAMPLES, SEED)
    body_pairs = [(g, *pair) for g, links in enumerate(link_pairs) for pair in bodies.pairs_of([links])]
    table = np.array(body_pairs, dtype=np.int64).reshape(len(body_pairs), 3)
    touching = np.empty((len(link_pairs), SAMPLES), dtype=np.bool_)
    groups, pairs = np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1:])
    vertices = None if bodies.only_boxes else bodies.vertices
    entry("overlap.overlap_groups")(tree.joints, bodies.table, vertices, pairs, groups, for_kernel(q), touching)
    return [_judged(a, b, touches, q) for (a, b), touches in zip(link_pairs, touching, strict=True)]


def _judged(a: str, b: str, touches: NDArray[np.bool_], q: NDArray[np.float64]) -> LinkPair:
    count = int(np.count_nonzero(touches))
    reason = NEVER if count == 0 else ALWAYS if count == len(touches) else SOMETIMES
    return LinkPair(a, b, reason, count, len(touches), tuple(q[int(np.argmax(touches))].tolist()))
