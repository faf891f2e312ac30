"""Tests a scene for overlap on a GPU, and searches it for the nearest pair.

Pairs and the solids outside of a BVH are tested one by one, bounding spheres first. A BVH is searched by the CPU's kernels, one
body after the other. There the threads of a warp diverge and wait for each other, so only scenes of many solids have a BVH.
"""

from functools import cache
from math import prod
from typing import Any

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat
from ulna.errors import DeviceError
from ulna.gpu import device, staged
from ulna.gpu.scenes import ANY, BOXES, DeviceScene
from ulna.gpu.staged import over_rows, threads_for
from ulna.kernels.chain.poses import frame_pose, tree_poses
from ulna.kernels.collision.bvh import FOUND, STACK, bounds_of, rows_within
from ulna.kernels.collision.nearest import nearest_of_body, nearest_unindexed
from ulna.kernels.collision.overlap import overlaps_any
from ulna.kernels.collision.posed_pair import BALLS, body_at, may_touch, object_at, place_bodies, rows_overlap
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.layout import REACH
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import constant_pose, load_pose
from ulna.kernels.spatial.vectors import dot, minus, origin

_MAX_SCRATCH, _MAX_DISTANCES = 0.25, 1 << 15  # fraction of the free memory; threads that measure distances
_BYTES = 8


def distance_scratch(scene: DeviceScene, n: int, stream: Any) -> tuple[list[Any], int]:
    """Scratch for n distances on a stream, and the number of threads that memory allows. Closed forms need no scratch."""
    if scene.sizes[3] != ANY:
        return [], device.LAUNCH.at_most
    each, at_least = _BYTES * sum(map(prod, SCRATCH)) / _MAX_SCRATCH, min(n, threads_for(scene.sizes[0], 1))
    threads = int(min(n, _MAX_DISTANCES, device.free_memory(at_least * each) / each))
    if threads < at_least:
        needed = at_least * each / 1e9
        raise DeviceError(f"too little memory is free on the device: distances of such shapes need {needed:.2g} GB")
    return [device.empty((threads, *shape), np.float64, stream) for shape in SCRATCH], threads


@kernel
def as_it_is(scene):
    """The scene of a launch."""
    return scene


@kernel
def of_boxes(scene):
    """The scene of a launch without vertices and points, since a launch accepts no None."""
    joints, bodies, _, pairs, objects, _, nodes, root, first, end, may_touch = scene
    return Scene(joints, bodies, None, pairs, objects, None, nodes, root, first, end, may_touch)


@cache
def overlaps_of(n_dof: int, n_joints: int, n_bodies: int, kind: int, is_indexed: bool) -> Any:
    """The driver for scenes of these sizes: whether each q is in collision, bools of shape (n, 1), by (scene,)."""
    of_joints, as_scene = 12 * n_joints, of_boxes if kind == BOXES else as_it_is
    of_tree = any_overlaps_indexed if is_indexed else no_overlap

    @kernel
    def overlaps(tables, q, _place, scratch, out, _marks):
        scene, center_rows = as_scene(tables[0]), scratch[of_joints:]
        place_centers(scene, q, scratch[:of_joints], center_rows)
        hits = any_overlaps(scene, scratch[:of_joints], center_rows, q[0])
        out[0] = hits or of_tree(scene, scratch[:of_joints], q[0])
        return not all_in_range(q)

    return over_rows(overlaps, n_dof, 1, scratch=of_joints + 3 * n_bodies, dtype=np.bool_)


@kernel
def place_centers(scene, q, joint_rows, center_rows):
    """Write the poses of the joints, and the origins of the bodies, three rows each.

    A thread's rows are in local memory, which all threads together would fill beyond the caches. Bounding spheres separate most
    pairs, and need the origin only; for the others the body's pose is computed again.
    """
    tree_poses(scene.joints, q, joint_rows)
    for k in range(scene.bodies.shape[0]):
        p = origin(frame_pose(scene.bodies, k, joint_rows, q[0]))
        center_rows[3 * k], center_rows[3 * k + 1], center_rows[3 * k + 2] = p


@kernel
def any_overlaps(scene, joint_rows, center_rows, like):
    """Whether any body overlaps an object, or another body of the pairs."""
    bodies, objects = scene.bodies, scene.objects
    for k in range(bodies.shape[0]):
        p, reach_k = (center_rows[3 * k], center_rows[3 * k + 1], center_rows[3 * k + 2]), bodies[k, REACH]
        for w in range(scene.first, scene.end):
            d, reach = minus(p, (objects[w, 3], objects[w, 7], objects[w, 11])), BALLS * (reach_k + objects[w, REACH])
            if dot(d, d) <= reach * reach and not may_touch(scene, k, w):
                ours = body_at(scene, k, frame_pose(bodies, k, joint_rows, like))
                if rows_overlap(ours, object_at(scene, w, constant_pose(objects, w, like)), splat(1.0, like)):
                    return True
    for m in range(scene.pairs.shape[0]):
        k, j = scene.pairs[m, 0], scene.pairs[m, 1]
        p, q = 3 * k, 3 * j
        d = center_rows[p] - center_rows[q], center_rows[p + 1] - center_rows[q + 1], center_rows[p + 2] - center_rows[q + 2]
        reach = BALLS * (bodies[k, REACH] + bodies[j, REACH])
        if dot(d, d) <= reach * reach:
            ours = body_at(scene, k, frame_pose(bodies, k, joint_rows, like))
            if rows_overlap(ours, body_at(scene, j, frame_pose(bodies, j, joint_rows, like)), splat(1.0, like)):
                return True
    return False


@kernel
def any_overlaps_indexed(scene, joint_rows, like):
    """Whether any body overlaps an object of the BVH."""
    stack, found = staged.cuda.local.array(STACK, np.int64), staged.cuda.local.array(FOUND, np.int64)
    for k in range(scene.bodies.shape[0]):
        pose = frame_pose(scene.bodies, k, joint_rows, like)
        bounds = bounds_of(scene.bodies, k, pose)
        stack[0], top = scene.root, 1
        while top > 0:
            n_found, top = rows_within(scene, bounds, stack, top, found)
            if overlaps_any(scene, body_at(scene, k, pose), found, n_found):
                return True
    return False


@kernel
def no_overlap(_scene, _joint_rows, _like):
    """No overlap: there is no BVH."""
    return False


@cache
def distances_of(n_dof: int, n_joints: int, n_bodies: int, kind: int, is_indexed: bool) -> Any:
    """The driver for scenes of these sizes: the minimum signed distance of each q, shape (n, 1).

    Its tables are (scene,); for ANY shapes (scene, points, faces, edges) with the scratch of EPA, one array per thread. So the
    number of threads is at most the number of these arrays.
    """
    of_joints, as_scene = 12 * n_joints, of_boxes if kind == BOXES else as_it_is
    scratch_of, nearest = _scratch_of_thread if kind == ANY else _no_scratch, nearest_of_all if is_indexed else nearest_unindexed

    @kernel
    def distances(tables, q, place, scratch, out, _marks):
        scene, body_rows = as_scene(tables[0]), scratch[of_joints:]
        place_bodies(scene.joints, scene.bodies, q, scratch[:of_joints], body_rows)
        out[0] = nearest(scene, body_rows, q[0], scratch_of(tables, place[2]))[0]
        return not all_in_range(q)

    return over_rows(distances, n_dof, 1, scratch=of_joints + 12 * n_bodies)


@kernel
def _scratch_of_thread(tables, thread):
    """The scratch of EPA for a thread."""
    return tables[1][thread], tables[2][thread], tables[3][thread]


@kernel
def _no_scratch(_tables, _thread):
    """None: closed forms need no scratch."""
    return


@kernel
def nearest_of_all(scene, body_rows, like, scratch):
    """The nearest pair, objects of the BVH included."""
    stack, heights = staged.cuda.local.array(STACK, np.int64), staged.cuda.local.array(STACK, np.float64)
    best = nearest_unindexed(scene, body_rows, like, scratch)
    for k in range(scene.bodies.shape[0]):
        pose = load_pose(body_rows, k)
        ours, bounds = body_at(scene, k, pose), bounds_of(scene.bodies, k, pose)
        best = nearest_of_body(best, scene, ours, bounds, (stack, heights), scratch)
    return best
