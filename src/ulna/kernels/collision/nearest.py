"""Finds the pair of minimum signed distance: robot with itself, robot with world.

A result is three numbers: the distance [m], infinite if there is no pair; the body of the robot; and the other body or the
object. Objects are numbered after the n bodies: object w has the number n + w.
"""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, lane_of, splat, where
from ulna.kernels.collision.bvh import child_gap, gap_bound, lane_bounds, push_children
from ulna.kernels.collision.posed_pair import ball_distance, body_at, may_touch, object_at, rows_contact, solid_at
from ulna.kernels.spatial.se3 import constant_pose, lane_pose, load_pose


@kernel
def nearer_pair(best, ours, theirs, number, scratch):
    """The nearer of the best pair and another pair.

    The other pair is measured only in lanes whose bounding balls are nearer than the best pair. number: The number of the other
    body or object.
    """
    if not any_lane(ball_distance(ours, theirs) < best[0]):
        return best
    distance = rows_contact(ours, theirs, scratch)[0]
    nearer = distance < best[0]
    return where(nearer, distance, best[0]), where(nearer, float(ours.row), best[1]), where(nearer, float(number), best[2])


@kernel
def nearest_unindexed(scene, body_rows, like, scratch):
    """The nearest pair among the robot's bodies and the unindexed objects, then among the robot's own pairs.

    One loop does both: the distance code is inlined at each call, and takes long to compile.
    """
    best = splat(np.inf, like), splat(-1.0, like), splat(-1.0, like)
    n, n_unindexed = scene.bodies.shape[0], scene.end - scene.first
    n_of_world = n * n_unindexed
    for m in range(n_of_world + scene.pairs.shape[0]):
        if m < n_of_world:
            i, w = m // n_unindexed, scene.first + m % n_unindexed
            if may_touch(scene, i, w):
                continue
            theirs, number = object_at(scene, w, constant_pose(scene.objects, w, like)), n + w
        else:
            i, number = scene.pairs[m - n_of_world, 0], scene.pairs[m - n_of_world, 1]
            theirs = body_at(scene, number, load_pose(body_rows, number))
        best = nearer_pair(best, body_at(scene, i, load_pose(body_rows, i)), theirs, number, scratch)
    return best


@kernel
def nearest_indexed(best, scene, body_rows, bound_rows, lane, search, scratch):
    """The nearer of the best pair and the pairs of the robot, in one lane, with the indexed objects.

    search: A stack of nodes, and a stack of the lower bounds of their distances. All lanes compute the same, so that the distance
    is compiled for lanes only.
    """
    for k in range(scene.bodies.shape[0]):
        bounds, ours = lane_bounds(bound_rows, k, lane), body_at(scene, k, splat_pose(lane_pose(body_rows, k, lane), best[0]))
        best = nearest_of_body(best, scene, ours, bounds, search, scratch)
    return best


@kernel
def nearest_of_body(best, scene, ours, bounds, search, scratch):
    """The nearer of the best pair and the pairs of one body (``scene.Posed``) with the indexed objects.

    The search is depth first, the nearest child first. A node certainly farther than the best pair is pruned.
    """
    n, like, (stack, heights) = scene.bodies.shape[0], best[0], search
    stack[0], heights[0], top = scene.root, -np.inf, 1
    while top > 0:
        top -= 1
        node, nearest = stack[top], lane_of(best[0], 0)
        if heights[top] < nearest:
            if node >= 0:
                height = gap_bound(child_gap(scene, node, bounds))
                top = push_children(scene, node, height, nearest, stack, heights, top)
            else:
                w = -1 - node
                theirs = solid_at(scene, w, like)
                if may_touch(scene, ours.row, theirs.row):
                    continue
                best = nearer_pair(best, ours, theirs, n + w, scratch)
    return best


@kernel
def splat_result(best_rows, lane, like):
    """The result of one lane in all lanes."""
    return splat(best_rows[0, lane], like), splat(best_rows[1, lane], like), splat(best_rows[2, lane], like)


@kernel
def splat_pose(a, like):
    """A pose of plain numbers in all lanes."""
    return (
        splat(a[0], like), splat(a[1], like), splat(a[2], like), splat(a[3], like), splat(a[4], like), splat(a[5], like),
        splat(a[6], like), splat(a[7], like), splat(a[8], like), splat(a[9], like), splat(a[10], like), splat(a[11], like),
    )  # fmt: skip
