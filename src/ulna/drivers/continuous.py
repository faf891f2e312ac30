"""Runs continuous collision checking over a batch of edges. Used by ``collision.checker``."""

import numpy as np

from ulna.drivers.batch import all_in_range
from ulna.engine.decorators import entry
from ulna.engine.lanes import lane_bits, load, logical_not, lowest_bit, store
from ulna.engine.signatures import INDICES, MATRIX, NUMBER, NUMBERS, SCENES
from ulna.engine.width import WIDTH
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import EDGE_CONTACT, EDGE_FREE, EDGE_OUT_OF_RANGE
from ulna.kernels.collision.continuous import INSTANT, clear_intervals, fastest_of, world_rounding, write_speeds
from ulna.kernels.collision.posed_pair import place_bodies


@entry(*((*scene, MATRIX, MATRIX, NUMBER, INDICES, NUMBERS) for scene in SCENES))
def edges_each(joints, bodies, vertices, pairs, objects, points, nodes, n_unindexed, q_a, q_b, resolution, status, contact):
    """Write to status, shape (n,), what the edge from each row of q_a to that of q_b is, and to contact how far it is free."""
    n_dof, n_indexed = q_a.shape[1], objects.shape[0] - n_unindexed
    q_rows, centre_row = np.zeros((max(1, n_dof), WIDTH)), np.empty((1, WIDTH))
    joint_rows, body_rows = np.empty((12 * joints.shape[0], WIDTH)), np.empty((12 * bodies.shape[0], WIDTH))
    speeds = np.empty((bodies.shape[0], joints.shape[0] + 2))
    stack, found, of_world = np.empty(STACK, np.int64), np.empty(n_indexed, np.int64), world_rounding(objects, nodes, n_unindexed)
    for e in range(q_a.shape[0]):
        contact[e] = 0.0
        if not (all_in_range(q_a[e]) and all_in_range(q_b[e])):
            status[e] = EDGE_OUT_OF_RANGE
            continue
        write_speeds(joints, bodies, q_a[e], q_b[e], speeds)
        fastest = fastest_of(speeds, pairs)
        t, length, status[e] = 0.0, 1.0, EDGE_CONTACT
        while True:
            last = length >= 1.0 - t
            step = (1.0 - t if last else length) / WIDTH
            for lane in range(WIDTH):
                centre_row[0, lane] = t + (lane + 0.5) * step
            for k in range(n_dof):
                store(q_rows, k, load(centre_row, 0) * (q_b[e, k] - q_a[e, k]) + q_a[e, k])
            place_bodies(joints, bodies, q_rows, joint_rows, body_rows)
            finest = fastest * step <= resolution
            clear = clear_intervals(
                bodies, vertices, pairs, objects, points, nodes, n_unindexed, body_rows, speeds, 0.5 * step + INSTANT,
                of_world, finest, load(q_rows, 0), stack, found,
            )  # fmt: skip
            blocked = lane_bits(logical_not(clear > 0.0))
            n_clear = lowest_bit(blocked) if blocked != 0 else WIDTH
            if n_clear == WIDTH and last:
                status[e], contact[e] = EDGE_FREE, 1.0
                break
            t += n_clear * step
            if n_clear < WIDTH and finest:
                contact[e] = t
                break
            length = step if n_clear < WIDTH else length * WIDTH
    return True
