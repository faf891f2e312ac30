"""Verdicts: whether the robot at q touches itself or the world. Poses from the tree, then pair after pair.

``pairs``: the robot's bodies that may touch each other, two indices a row, shape (n_pairs, 2). ``objects``: the world's bodies.
"""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.compile import entry, kernel
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.placed import place_bodies
from ulna.kernels.robot_boxes import pair_overlaps
from ulna.kernels.se3 import constant_pose, load_pose

FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2


@kernel
def pair_hits(bodies, pairs, p, body_rows):
    """True where the two bodies of pair p overlap."""
    a, b = pairs[p, 0], pairs[p, 1]
    return pair_overlaps(bodies, a, load_pose(body_rows, a), bodies, b, load_pose(body_rows, b))


@kernel
def object_hits(bodies, k, body_rows, objects, w, like):
    """True where body k of the robot overlaps object w."""
    return pair_overlaps(bodies, k, load_pose(body_rows, k), objects, w, constant_pose(objects, w, like))


@entry
def overlap_one(joints, bodies, pairs, objects, q):
    """FREE or OVERLAPS for one q, at the first pair found; OUT_OF_RANGE if an entry of q is."""
    if not all_in_range(q):
        return OUT_OF_RANGE
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for k in range(bodies.shape[0]):
        for w in range(objects.shape[0]):
            if any_lane(object_hits(bodies, k, body_rows, objects, w, load(q, 0))):
                return OVERLAPS
    for p in range(pairs.shape[0]):
        if any_lane(pair_hits(bodies, pairs, p, body_rows)):
            return OVERLAPS
    return FREE


@entry
def overlap_batch(joints, bodies, pairs, objects, q, out):
    """Write to the bools of out, shape (n,), whether the robot touches anything. False if an entry of q is out of range."""
    n = q.shape[0]
    q_rows, hit_rows = np.zeros((max(1, q.shape[1]), WIDTH)), np.empty((1, WIDTH))
    joint_rows, body_rows = np.empty((12 * joints.shape[0], WIDTH)), np.empty((12 * bodies.shape[0], WIDTH))
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
        hits = splat(0.0, load(q_rows, 0))
        for k in range(bodies.shape[0]):
            for w in range(objects.shape[0]):
                hits = where(object_hits(bodies, k, body_rows, objects, w, hits), 1.0, hits)
        for p in range(pairs.shape[0]):
            hits = where(pair_hits(bodies, pairs, p, body_rows), 1.0, hits)
        store(hit_rows, 0, hits)
        for lane in range(WIDTH):
            out[min(start + lane, n - 1)] = hit_rows[0, lane] > 0.0
    return good


@entry
def overlap_groups(joints, bodies, pairs, groups, q, out):
    """Write to the bools of out, shape (n_groups, n), which groups of pairs touch at each q; pair p belongs to groups[p]."""
    n = q.shape[0]
    q_rows, hit_rows = np.zeros((max(1, q.shape[1]), WIDTH)), np.empty((out.shape[0], WIDTH))
    joint_rows, body_rows = np.empty((12 * joints.shape[0], WIDTH)), np.empty((12 * bodies.shape[0], WIDTH))
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
        for g in range(out.shape[0]):
            store(hit_rows, g, splat(0.0, load(q_rows, 0)))
        for p in range(pairs.shape[0]):
            hits = load(hit_rows, groups[p])
            store(hit_rows, groups[p], where(pair_hits(bodies, pairs, p, body_rows), 1.0, hits))
        for g in range(out.shape[0]):
            for lane in range(WIDTH):
                out[g, min(start + lane, n - 1)] = hit_rows[g, lane] > 0.0
