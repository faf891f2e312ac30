"""Verdicts: whether the robot at q touches itself or the world.

The robot is ``joints``, ``bodies`` with their ``vertices``, and ``pairs``: the bodies that may not touch each other, two indices a
row. The world is ``objects`` with their vertices (``points``): the first ``n_alone`` are met one by one, the others hang in the tree
of ``nodes`` (``bounds``). ``only_boxes`` says that there are no other shapes.

Boxes are met apart from the rest, in loops that call nothing: around a call Numba counts references to every array, at more cost
than the test of two boxes.
"""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.bounds import STACK, lane_bounds, objects_within, place_bounds
from ulna.kernels.compile import entry, kernel, routine
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.pair import body_of, pair_overlap
from ulna.kernels.placed import are_boxes, balls_meet, box_rows_overlap, lane_pose, place_bodies, robot_body, world_body
from ulna.kernels.se3 import constant_pose, load_pose

FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2


@kernel
def box_hits(bodies, pairs, objects, n_alone, body_rows, like):
    """1.0 where any two boxes overlap, of the pairs or of the robot and the single objects; 0.0 elsewhere."""
    hits = splat(0.0, like)
    for k in range(bodies.shape[0]):
        for w in range(n_alone):
            if are_boxes(bodies, k, objects, w):
                a, b = load_pose(body_rows, k), constant_pose(objects, w, like)
                if any_lane(balls_meet(bodies, k, a, objects, w, b)):
                    hits = where(box_rows_overlap(bodies, k, a, objects, w, b), 1.0, hits)
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        if are_boxes(bodies, i, bodies, j):
            a, b = load_pose(body_rows, i), load_pose(body_rows, j)
            if any_lane(balls_meet(bodies, i, a, bodies, j, b)):
                hits = where(box_rows_overlap(bodies, i, a, bodies, j, b), 1.0, hits)
    return hits


@routine
def other_hits(bodies, vertices, pairs, objects, points, n_alone, body_rows, like):
    """The same for pairs of which at least one is no box."""
    hits = splat(0.0, like)
    for k in range(bodies.shape[0]):
        for w in range(n_alone):
            if not are_boxes(bodies, k, objects, w):
                a, b = robot_body(bodies, vertices, k, body_rows), world_body(objects, points, w, like)
                hits = where(pair_overlap(a, b), 1.0, hits)
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        if not are_boxes(bodies, i, bodies, j):
            a, b = robot_body(bodies, vertices, i, body_rows), robot_body(bodies, vertices, j, body_rows)
            hits = where(pair_overlap(a, b), 1.0, hits)
    return hits


@kernel
def box_tree_hit(bodies, body_rows, bound_rows, lane, objects, nodes, n_alone, stack, found):
    """Whether any box of the robot, in one lane, overlaps any box of the tree."""
    for k in range(bodies.shape[0]):
        n_found = objects_within(nodes, objects.shape[0] - n_alone, lane_bounds(bound_rows, k, lane), stack, found)
        for i in range(n_found):
            w = n_alone + found[i]
            if are_boxes(bodies, k, objects, w):
                if box_rows_overlap(bodies, k, lane_pose(body_rows, k, lane), objects, w, constant_pose(objects, w, 0.0)):
                    return True
    return False


@routine
def other_tree_hit(bodies, vertices, body_rows, bound_rows, lane, objects, points, nodes, n_alone, stack, found):
    """The same for pairs of which at least one is no box."""
    for k in range(bodies.shape[0]):
        n_found = objects_within(nodes, objects.shape[0] - n_alone, lane_bounds(bound_rows, k, lane), stack, found)
        for i in range(n_found):
            w = n_alone + found[i]
            if not are_boxes(bodies, k, objects, w):
                a = body_of(bodies, vertices, k, lane_pose(body_rows, k, lane))
                if pair_overlap(a, world_body(objects, points, w, 0.0)):
                    return True
    return False


@entry
def overlap_one(joints, bodies, vertices, pairs, objects, points, nodes, n_alone, only_boxes, q):
    """FREE or OVERLAPS for one q; OUT_OF_RANGE if an entry of q is."""
    if not all_in_range(q):
        return OUT_OF_RANGE
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    if box_hits(bodies, pairs, objects, n_alone, body_rows, load(q, 0)) > 0.0:
        return OVERLAPS
    if not only_boxes and other_hits(bodies, vertices, pairs, objects, points, n_alone, body_rows, load(q, 0)) > 0.0:
        return OVERLAPS
    if nodes.shape[0] > 0:
        stack, found = np.empty(STACK, np.int64), np.empty(objects.shape[0] - n_alone, np.int64)
        bound_rows, one_lane = np.empty(6 * bodies.shape[0]), body_rows.reshape(-1, 1)
        place_bounds(bodies, body_rows, bound_rows)
        bounds = bound_rows.reshape(-1, 1)
        if box_tree_hit(bodies, one_lane, bounds, 0, objects, nodes, n_alone, stack, found):
            return OVERLAPS
        if not only_boxes:
            if other_tree_hit(bodies, vertices, one_lane, bounds, 0, objects, points, nodes, n_alone, stack, found):
                return OVERLAPS
    return FREE


@entry
def overlap_batch(joints, bodies, vertices, pairs, objects, points, nodes, n_alone, only_boxes, q, out):
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
        hits = box_hits(bodies, pairs, objects, n_alone, body_rows, load(q_rows, 0))
        if not only_boxes:
            hits = hits + other_hits(bodies, vertices, pairs, objects, points, n_alone, body_rows, load(q_rows, 0))
        store(hit_rows, 0, hits)
        if n_hung > 0:
            place_bounds(bodies, body_rows, bound_rows)
        for lane in range(WIDTH):
            hit = hit_rows[0, lane] > 0.0
            if n_hung > 0 and not hit:
                hit = box_tree_hit(bodies, body_rows, bound_rows, lane, objects, nodes, n_alone, stack, found)
            if n_hung > 0 and not hit and not only_boxes:
                hit = other_tree_hit(
                    bodies, vertices, body_rows, bound_rows, lane, objects, points, nodes, n_alone, stack, found
                )  # fmt: skip
            out[min(start + lane, n - 1)] = hit
    return good


@entry
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
            a, b = robot_body(bodies, vertices, pairs[p, 0], body_rows), robot_body(bodies, vertices, pairs[p, 1], body_rows)
            store(hit_rows, groups[p], where(pair_overlap(a, b), 1.0, load(hit_rows, groups[p])))
        for g in range(out.shape[0]):
            for lane in range(WIDTH):
                out[g, min(start + lane, n - 1)] = hit_rows[g, lane] > 0.0
