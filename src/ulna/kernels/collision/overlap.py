"""Tests whether the robot at q overlaps itself or the world.

Pairs and unindexed objects are tested one by one, the other objects where the BVH finds them (``scene``, ``bvh``).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, splat, where
from ulna.kernels.collision.bvh import lane_bounds, rows_within
from ulna.kernels.collision.posed_pair import balls_overlap, may_touch, rows_overlap, solid_at
from ulna.kernels.spatial.se3 import constant_pose, lane_pose, load_pose


@kernel
def overlaps_unindexed(scene, body_rows, like):
    """1.0 where any of the pairs overlaps, or any body of the robot and any unindexed object; 0.0 elsewhere."""
    hits, bodies, objects = splat(0.0, like), scene.bodies, scene.objects
    for k in range(bodies.shape[0]):
        for w in range(scene.first, scene.end):
            a, b = load_pose(body_rows, k), constant_pose(objects, w, like)
            near = balls_overlap(bodies, k, a, objects, w, b) & (hits < 1.0)
            if any_lane(near) and not may_touch(scene, k, w):
                wanted = where(near, 1.0, 0.0)
                hits = where(near & rows_overlap(bodies, scene.vertices, k, a, objects, scene.points, w, b, wanted), 1.0, hits)
    for p in range(scene.pairs.shape[0]):
        hits = pair_overlaps(bodies, scene.vertices, scene.pairs, p, body_rows, hits)
    return hits


@kernel
def pair_overlaps(bodies, vertices, pairs, p, body_rows, hits):
    """1.0 where the two bodies of pair p overlap, and where ``hits`` is 1.0; 0.0 elsewhere."""
    i, j = pairs[p, 0], pairs[p, 1]
    a, b = load_pose(body_rows, i), load_pose(body_rows, j)
    near = balls_overlap(bodies, i, a, bodies, j, b) & (hits < 1.0)
    if any_lane(near):
        wanted = where(near, 1.0, 0.0)
        return where(near & rows_overlap(bodies, vertices, i, a, bodies, vertices, j, b, wanted), 1.0, hits)
    return hits


@kernel
def overlaps_indexed(scene, body_rows, bound_rows, lane, stack, found):
    """Whether any body of the robot, in one lane, overlaps any indexed object."""
    bodies, objects = scene.bodies, scene.objects
    for k in range(bodies.shape[0]):
        bounds, top = lane_bounds(bound_rows, k, lane), 1
        stack[0] = scene.root
        while top > 0:
            n_found, top = rows_within(scene.nodes, bounds, stack, top, found)
            for i in range(n_found):
                row, b = solid_at(scene, found[i], 0.0)
                if may_touch(scene, k, row):
                    continue
                a = lane_pose(body_rows, k, lane)
                if rows_overlap(bodies, scene.vertices, k, a, objects, scene.points, row, b, 1.0):
                    return True
    return False
