"""Runs the overlap test over one q or a batch."""

import numpy as np

from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, empty_rows, load, store, zero_rows
from ulna.engine.signatures import MATRIX, NUMBERS, TRUTHS
from ulna.kernels.collision.bvh import FOUND, STACK, place_bounds
from ulna.kernels.collision.collision_layout import FREE, OUT_OF_RANGE, OVERLAPS
from ulna.kernels.collision.overlap import overlaps_indexed, overlaps_unindexed
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import BOXES, SHAPES
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kinematics.entries.batch import gather


@entry(*((scene, NUMBERS) for scene in (BOXES, SHAPES)))
def overlap_one(scene, q):
    """FREE or OVERLAPS for one q; OUT_OF_RANGE if an entry of q is out of range."""
    if not all_in_range(q):
        return OUT_OF_RANGE
    joints, bodies = scene.joints, scene.bodies
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    if overlaps_unindexed(scene, body_rows, load(q, 0)) > 0.0:
        return OVERLAPS
    if scene.root >= 0:
        stack, found, bound_rows = np.empty(STACK, np.int64), np.empty(FOUND, np.int64), np.empty(6 * bodies.shape[0])
        place_bounds(bodies, body_rows, bound_rows)
        at, within = body_rows.reshape(-1, 1), bound_rows.reshape(-1, 1)
        if overlaps_indexed(scene, at, within, 0, stack, found):
            return OVERLAPS
    return FREE


@entry(*((scene, MATRIX, TRUTHS) for scene in (BOXES, SHAPES)))
def overlap_batch(scene, q, out):
    """Write whether the robot touches anything at each q to the bools of out, shape (n,).

    Pairs and unindexed objects are tested for eight configurations at once. The BVH is searched for one after the other, since
    each search takes its own path. Returns False if an entry of q is out of range.
    """
    joints, bodies, n, has_tree = scene.joints, scene.bodies, q.shape[0], scene.root >= 0
    q_rows, hit_rows = zero_rows(max(1, q.shape[1])), empty_rows(1)
    joint_rows, body_rows = empty_rows(12 * joints.shape[0]), empty_rows(12 * bodies.shape[0])
    stack, found, bound_rows = np.empty(STACK, np.int64), np.empty(FOUND, np.int64), empty_rows(6 * bodies.shape[0])
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
        store(hit_rows, 0, overlaps_unindexed(scene, body_rows, load(q_rows, 0)))
        if has_tree:
            place_bounds(bodies, body_rows, bound_rows)
        for lane in range(WIDTH):
            out[min(start + lane, n - 1)] = hit_rows[0, lane] > 0.0 or (
                has_tree and overlaps_indexed(scene, body_rows, bound_rows, lane, stack, found)
            )
    return good
