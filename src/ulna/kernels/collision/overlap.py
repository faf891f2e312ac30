"""Tests whether the robot at q overlaps itself or the world. Used by ``drivers.overlap``.

The robot is ``joints``, ``bodies`` with their ``vertices``, and ``pairs``: the bodies that are tested against each other,
two indices a row. The world is ``objects`` with their vertices (``points``): the first ``n_unindexed`` are tested one by one, the
others are indexed by the BVH of ``nodes`` (``bvh``).
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, splat, where
from ulna.kernels.collision.bvh import lane_bounds, objects_within
from ulna.kernels.collision.posed_pair import balls_meet, lane_pose, rows_overlap
from ulna.kernels.spatial.se3 import constant_pose, load_pose


@kernel
def overlaps_unindexed(bodies, vertices, pairs, objects, points, n_unindexed, body_rows, like):
    """1.0 where any of the pairs overlaps, or any body of the robot and any unindexed object; 0.0 elsewhere."""
    hits = splat(0.0, like)
    for k in range(bodies.shape[0]):
        for w in range(n_unindexed):
            a, b = load_pose(body_rows, k), constant_pose(objects, w, like)
            if any_lane(balls_meet(bodies, k, a, objects, w, b)):
                hits = where(rows_overlap(bodies, vertices, k, a, objects, points, w, b), 1.0, hits)
    for p in range(pairs.shape[0]):
        hits = where(pair_overlaps(bodies, vertices, pairs, p, body_rows), 1.0, hits)
    return hits


@kernel
def pair_overlaps(bodies, vertices, pairs, p, body_rows):
    """True where the two bodies of pair p overlap."""
    i, j = pairs[p, 0], pairs[p, 1]
    a, b = load_pose(body_rows, i), load_pose(body_rows, j)
    near = balls_meet(bodies, i, a, bodies, j, b)
    if any_lane(near):
        return rows_overlap(bodies, vertices, i, a, bodies, vertices, j, b)
    return near


@kernel
def overlaps_indexed(bodies, vertices, body_rows, bound_rows, lane, objects, points, nodes, n_unindexed, stack, found):
    """Whether any body of the robot, in one lane, overlaps any indexed object."""
    for k in range(bodies.shape[0]):
        n_found = objects_within(nodes, objects.shape[0] - n_unindexed, lane_bounds(bound_rows, k, lane), stack, found)
        for i in range(n_found):
            w = n_unindexed + found[i]
            a, b = lane_pose(body_rows, k, lane), constant_pose(objects, w, 0.0)
            if rows_overlap(bodies, vertices, k, a, objects, points, w, b):
                return True
    return False
