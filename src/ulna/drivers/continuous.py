"""Runs continuous collision checking over a batch of edges. Used by ``collision.checker``."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.drivers.free_edge import MOST_BLOCKS, edge_is_free, free_edge_work, interval_work
from ulna.engine.decorators import entry, routine, workspace
from ulna.engine.lanes import empty_rows, lane_bits, load, logical_not, lowest_bit, store, zero_rows
from ulna.engine.signatures import INDICES, MATRIX, NUMBER, NUMBERS, SCENES
from ulna.engine.width import WIDTH
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import EDGE_CONTACT, EDGE_FREE, EDGE_OUT_OF_RANGE
from ulna.kernels.collision.continuous import INSTANT, clear_intervals, fastest_of, world_rounding, write_speeds
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import Scene
from ulna.kernels.spatial.elementary import all_in_range


class EdgeWork(NamedTuple):
    """The workspace of ``certify_edge``: one per thread is enough for any number of edges of a scene."""

    q_rows: NDArray
    """Eight configurations, shape (max(1, n_dof), 8)."""
    centre_row: NDArray
    """The middles of eight intervals, shape (1, 8)."""
    joint_rows: NDArray
    """Eight poses of every joint, shape (12 n_joints, 8)."""
    body_rows: NDArray
    """Eight poses of every body, shape (12 n_bodies, 8)."""
    speeds: NDArray
    """Those of ``write_speeds``, shape (n_bodies, n_joints + 2)."""
    stack: NDArray
    """Nodes of the BVH, shape (STACK,)."""
    found: NDArray
    """Indexed objects, shape (n_indexed,)."""


@workspace
def edge_work(scene, n_dof):
    """A workspace for the edges of a scene."""
    n_joints, n_bodies = scene.joints.shape[0], scene.bodies.shape[0]
    return EdgeWork(
        zero_rows(max(1, n_dof)),
        empty_rows(1),
        empty_rows(12 * n_joints),
        empty_rows(12 * n_bodies),
        np.empty((n_bodies, n_joints + 2)),
        np.empty(STACK, np.int64),
        np.empty(scene.objects.shape[0] - scene.n_unindexed, np.int64),
    )


@routine
def certify_edge(scene, q_a, q_b, resolution, of_world, work):
    """The certificate of the straight line from q_a to q_b (``kernels.collision.continuous``, steps 2 and 3).

    of_world: ``world_rounding(scene)``. Returns EDGE_FREE and 1.0; or EDGE_CONTACT and t, up to which the edge is free; or
    EDGE_OUT_OF_RANGE and 0.0.
    """
    if not (all_in_range(q_a) and all_in_range(q_b)):
        return EDGE_OUT_OF_RANGE, 0.0
    write_speeds(scene, q_a, q_b, work.speeds)
    fastest = fastest_of(work.speeds, scene.pairs)
    t, length = 0.0, 1.0
    while True:
        last = length >= 1.0 - t
        step = (1.0 - t if last else length) / WIDTH
        for lane in range(WIDTH):
            work.centre_row[0, lane] = t + (lane + 0.5) * step
        for k in range(q_a.shape[0]):
            store(work.q_rows, k, load(work.centre_row, 0) * (q_b[k] - q_a[k]) + q_a[k])
        place_bodies(scene.joints, scene.bodies, work.q_rows, work.joint_rows, work.body_rows)
        finest = fastest * step <= resolution
        clear = clear_intervals(
            scene,
            work.body_rows,
            work.speeds,
            0.5 * step + INSTANT,
            of_world,
            finest,
            load(work.q_rows, 0),
            work.stack,
            work.found,
        )
        blocked = lane_bits(logical_not(clear > 0.0))
        n_clear = lowest_bit(blocked) if blocked != 0 else WIDTH
        if n_clear == WIDTH and last:
            return EDGE_FREE, 1.0
        t += n_clear * step
        if n_clear < WIDTH and finest:
            return EDGE_CONTACT, t
        length = step if n_clear < WIDTH else length * WIDTH


@entry(*((*scene, MATRIX, MATRIX, NUMBER, INDICES, NUMBERS) for scene in SCENES))
def edges_each(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, q_a, q_b, resolution, status, contact):
    """Write to status, shape (n,), what the edge from each row of q_a to that of q_b is, and to contact how far it is free."""
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed)
    work, of_world = edge_work(scene, q_a.shape[1]), world_rounding(scene)
    carried = free_edge_work(scene, np.zeros((bodies.shape[0], n_unindexed), np.bool_))
    intervals, no_spread = interval_work(scene, q_a.shape[1]), np.zeros(q_a.shape[1])
    for e in range(q_a.shape[0]):
        in_range = all_in_range(q_a[e]) and all_in_range(q_b[e])
        if in_range and edge_is_free(
            scene, carried, intervals, q_a[e], q_b[e], no_spread, resolution, 0.0, of_world, MOST_BLOCKS
        ):
            status[e], contact[e] = EDGE_FREE, 1.0
        else:
            status[e], contact[e] = certify_edge(scene, q_a[e], q_b[e], resolution, of_world, work)
    return True
