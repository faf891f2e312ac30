"""Verdicts: whether the robot at q touches itself or the world.

The robot is ``joints``, ``bodies`` with their ``vertices``, and ``pairs``: the bodies that may not touch each other, two
indices a row. The world is ``objects`` with their vertices (``points``): the first ``n_alone`` are met one by one, the others
hang in the tree of ``nodes`` (``bounds``).
"""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.bounds import STACK, lane_bounds, objects_within, place_bounds
from ulna.kernels.compile import entry, kernel
from ulna.kernels.kinds import INDEX_ROWS, INDICES, MATRIX, NUMBERS, SCENES, TRUTH_ROWS, TRUTHS
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.placed import balls_meet, lane_pose, place_bodies, rows_overlap
from ulna.kernels.se3 import constant_pose, load_pose

FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2


@kernel
def hits_alone(bodies, vertices, pairs, objects, points, n_alone, body_rows, like):
    """1.0 where any of the pairs overlaps, or any body of the robot and any single object; 0.0 elsewhere."""
    hits = splat(0.0, like)
    for k in range(bodies.shape[0]):
        for w in range(n_alone):
            a, b = load_pose(body_rows, k), constant_pose(objects, w, like)
            if any_lane(balls_meet(bodies, k, a, objects, w, b)):
                hits = where(rows_overlap(bodies, vertices, k, a, objects, points, w, b), 1.0, hits)
    for p in range(pairs.shape[0]):
        hits = where(pair_hits(bodies, vertices, pairs, p, body_rows), 1.0, hits)
    return hits


@kernel
def pair_hits(bodies, vertices, pairs, p, body_rows):
    """True where the two bodies of pair p overlap."""
    i, j = pairs[p, 0], pairs[p, 1]
    a, b = load_pose(body_rows, i), load_pose(body_rows, j)
    near = balls_meet(bodies, i, a, bodies, j, b)
    if any_lane(near):
        return rows_overlap(bodies, vertices, i, a, bodies, vertices, j, b)
    return near


@kernel
def tree_hit(bodies, vertices, body_rows, bound_rows, lane, objects, points, nodes, n_alone, stack, found):
    """Whether any body of the robot, in one lane, overlaps any object of the tree."""
    for k in range(bodies.shape[0]):
        n_found = objects_within(nodes, objects.shape[0] - n_alone, lane_bounds(bound_rows, k, lane), stack, found)
        for i in range(n_found):
            w = n_alone + found[i]
            a, b = lane_pose(body_rows, k, lane), constant_pose(objects, w, 0.0)
            if rows_overlap(bodies, vertices, k, a, objects, points, w, b):
                return True
    return False


@entry(*((*scene, NUMBERS) for scene in SCENES))
def overlap_one(joints, bodies, vertices, pairs, objects, points, nodes, n_alone, q):
    """FREE or OVERLAPS for one q; OUT_OF_RANGE if an entry of q is."""
    if not all_in_range(q):
        return OUT_OF_RANGE
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    if hits_alone(bodies, vertices, pairs, objects, points, n_alone, body_rows, load(q, 0)) > 0.0:
        return OVERLAPS
    n_hung = objects.shape[0] - n_alone
    if n_hung > 0:
        stack, found, bound_rows = np.empty(STACK, np.int64), np.empty(n_hung, np.int64), np.empty(6 * bodies.shape[0])
        place_bounds(bodies, body_rows, bound_rows)
        at, within = body_rows.reshape(-1, 1), bound_rows.reshape(-1, 1)
        if tree_hit(bodies, vertices, at, within, 0, objects, points, nodes, n_alone, stack, found):
            return OVERLAPS
    return FREE


@entry(*((*scene, MATRIX, TRUTHS) for scene in SCENES))
def overlap_batch(joints, bodies, vertices, pairs, objects, points, nodes, n_alone, q, out):
    """Write to the bools of out, shape (n,), whether the robot touches anything. False if an entry of q is out of range.

    Pairs and single objects are met by eight configurations at once; the tree by one after the other, for each goes its own way.
    """
    n, n_hung = q.shape[0], objects.shape[0] - n_alone
    q_rows, hit_rows = np.zeros((max(1, q.shape[1]), WIDTH)), np.empty((1, WIDTH))
    joint_rows, body_rows = np.empty((12 * joints.shape[0], WIDTH)), np.empty((12 * bodies.shape[0], WIDTH))
    stack, found, bound_rows = np.empty(STACK, np.int64), np.empty(n_hung, np.int64), np.empty((6 * bodies.shape[0], WIDTH))
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
        store(hit_rows, 0, hits_alone(bodies, vertices, pairs, objects, points, n_alone, body_rows, load(q_rows, 0)))
        if n_hung > 0:
            place_bounds(bodies, body_rows, bound_rows)
        for lane in range(WIDTH):
            out[min(start + lane, n - 1)] = hit_rows[0, lane] > 0.0 or (
                n_hung > 0
                and tree_hit(bodies, vertices, body_rows, bound_rows, lane, objects, points, nodes, n_alone, stack, found)
            )
    return good


@entry(*((*scene[:3], INDEX_ROWS, INDICES, MATRIX, TRUTH_ROWS) for scene in SCENES))
def overlap_groups(joints, bodies, vertices, pairs, groups, q, out):
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
            hits = pair_hits(bodies, vertices, pairs, p, body_rows)
            store(hit_rows, groups[p], where(hits, 1.0, load(hit_rows, groups[p])))
        for g in range(out.shape[0]):
            for lane in range(WIDTH):
                out[g, min(start + lane, n - 1)] = hit_rows[g, lane] > 0.0
