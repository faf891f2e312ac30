"""Finds the nearest pair at each configuration of a batch."""

import numpy as np

from ulna.collision.entries.contacts import scratch_of_epa
from ulna.engine.decorators import entry
from ulna.engine.lanes import WIDTH, empty_rows, lane_of, load, store, zero_rows
from ulna.engine.signatures import MATRIX, Array
from ulna.kernels.collision.bvh import STACK, place_bounds
from ulna.kernels.collision.nearest import nearest_indexed, nearest_unindexed, splat_result
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import BOXES, SHAPES, NearestPair
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kinematics.entries.batch import gather


@entry(*((scene, MATRIX, Array(NearestPair, 1)) for scene in (BOXES, SHAPES)))
def nearest_batch(scene, q, out):
    """Write the nearest pair at each q of shape (n, n_dof) to out, shape (n,).

    Eight configurations are measured at a time, but the BVH is searched for one after the other. Returns False if an entry of q
    is out of range.
    """
    joints, bodies, n, has_tree = scene.joints, scene.bodies, q.shape[0], scene.root >= 0
    q_rows, best_rows = zero_rows(max(1, q.shape[1])), empty_rows(3)
    joint_rows, body_rows = empty_rows(12 * joints.shape[0]), empty_rows(12 * bodies.shape[0])
    stack, heights, bound_rows = np.empty(STACK, np.int64), np.empty(STACK), empty_rows(6 * bodies.shape[0])
    scratch = scratch_of_epa(scene)
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
        best = nearest_unindexed(scene, body_rows, load(q_rows, 0), scratch)
        store(best_rows, 0, best[0])
        store(best_rows, 1, best[1])
        store(best_rows, 2, best[2])
        if has_tree:
            place_bounds(bodies, body_rows, bound_rows)
        for lane in range(min(WIDTH, n - start)):
            if has_tree:
                one = splat_result(best_rows, lane, load(q_rows, 0))
                one = nearest_indexed(one, scene, body_rows, bound_rows, lane, (stack, heights), scratch)
                best_rows[0, lane], best_rows[1, lane] = lane_of(one[0], 0), lane_of(one[1], 0)
                best_rows[2, lane] = lane_of(one[2], 0)
            pair = out[start + lane]
            pair.distance, pair.body, pair.other = best_rows[0, lane], int(best_rows[1, lane]), int(best_rows[2, lane])
    return good
