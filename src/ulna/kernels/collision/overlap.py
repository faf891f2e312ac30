"""Tests whether the robot at q overlaps itself or the world.

Pairs and unindexed objects are tested one by one, other objects where the BVH finds them (``scene``, ``bvh``).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, splat, where
from ulna.kernels.collision.bvh import lane_bounds, rows_within
from ulna.kernels.collision.posed_pair import balls_overlap, body_at, may_touch, object_at, rows_overlap, solid_at
from ulna.kernels.spatial.se3 import constant_pose, lane_pose, load_pose


@kernel
def overlaps_unindexed(scene, body_rows, like):
    """1.0 where any pair overlaps, or any body of the robot and any unindexed object; 0.0 elsewhere."""
    hits = splat(0.0, like)
    for k in range(scene.bodies.shape[0]):
        for w in range(scene.first, scene.end):
            ours, theirs = body_at(scene, k, load_pose(body_rows, k)), object_at(scene, w, constant_pose(scene.objects, w, like))
            near = balls_overlap(ours, theirs) & (hits < 1.0)
            if any_lane(near) and not may_touch(scene, k, w):
                hits = where(near & rows_overlap(ours, theirs, where(near, 1.0, 0.0)), 1.0, hits)
    for p in range(scene.pairs.shape[0]):
        hits = pair_overlaps(scene, p, body_rows, hits)
    return hits


@kernel
def pair_overlaps(scene, p, body_rows, hits):
    """1.0 where the two bodies of pair p overlap, and where ``hits`` is 1.0; 0.0 elsewhere."""
    i, j = scene.pairs[p, 0], scene.pairs[p, 1]
    ours, theirs = body_at(scene, i, load_pose(body_rows, i)), body_at(scene, j, load_pose(body_rows, j))
    near = balls_overlap(ours, theirs) & (hits < 1.0)
    if any_lane(near):
        return where(near & rows_overlap(ours, theirs, where(near, 1.0, 0.0)), 1.0, hits)
    return hits


@kernel
def overlaps_indexed(scene, body_rows, bound_rows, lane, stack, found):
    """Whether any body of the robot, in one lane, overlaps any indexed object."""
    for k in range(scene.bodies.shape[0]):
        bounds = lane_bounds(bound_rows, k, lane)
        stack[0], top = scene.root, 1
        while top > 0:
            n_found, top = rows_within(scene, bounds, stack, top, found)
            if n_found > 0 and overlaps_any(scene, body_at(scene, k, lane_pose(body_rows, k, lane)), found, n_found):
                return True
    return False


@kernel
def overlaps_any(scene, ours, found, n_found):
    """Whether a body (``scene.Posed``) overlaps any of the solids in the first ``n_found`` entries of found."""
    for i in range(n_found):
        theirs = solid_at(scene, found[i], 0.0)
        if not may_touch(scene, ours.row, theirs.row) and rows_overlap(ours, theirs, 1.0):
            return True
    return False
