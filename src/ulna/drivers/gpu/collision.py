"""Runs the overlap test and the search for the nearest pair on a GPU. Used by ``robot.gpu_robot``.

All objects are tested one by one, ball against ball first: threads of a warp that each go their own way through a BVH would wait
for each other.
"""

from functools import cache

import numpy as np

from ulna.engine.gpu import cuda
from ulna.kernels.collision.nearest import nearest_unindexed
from ulna.kernels.collision.overlap import overlaps_unindexed
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import Scene
from ulna.kernels.spatial.elementary import all_in_range


@cache
def overlaps_of(n_joints: int, n_bodies: int):
    """The driver for robots of these sizes: whether each q touches anything, to the bools of out, shape (n,)."""
    of_joints, of_bodies = 12 * n_joints, 12 * n_bodies

    def overlaps(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, may_touch, q, out, out_of_range):
        i = cuda.grid(1)
        if i < q.shape[0]:
            if not all_in_range(q[i]):
                out_of_range[0] = 1
            scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, may_touch)
            joint_rows, body_rows = cuda.local.array(of_joints, np.float64), cuda.local.array(of_bodies, np.float64)
            place_bodies(joints, bodies, q[i], joint_rows, body_rows)
            out[i] = overlaps_unindexed(scene, body_rows, q[i, 0]) > 0.0

    return overlaps


@cache
def distances_of(n_joints: int, n_bodies: int):
    """The driver for robots of these sizes: the least signed distance of each q to out, shape (n,).

    The scratch of EPA is an array for each thread: points (m, ...), faces (m, ...) and edges (m, ...). So m threads do all.
    """
    of_joints, of_bodies = 12 * n_joints, 12 * n_bodies

    def distances(
        joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, may_touch,
        corners, faces, edges, q, out, out_of_range,
    ):  # fmt: skip
        thread = cuda.grid(1)
        if thread < corners.shape[0]:
            scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, may_touch)
            joint_rows, body_rows = cuda.local.array(of_joints, np.float64), cuda.local.array(of_bodies, np.float64)
            scratch = corners[thread], faces[thread], edges[thread]
            for i in range(thread, q.shape[0], corners.shape[0]):
                if not all_in_range(q[i]):
                    out_of_range[0] = 1
                place_bodies(joints, bodies, q[i], joint_rows, body_rows)
                out[i] = nearest_unindexed(scene, body_rows, q[i, 0], scratch)[0]

    return distances
