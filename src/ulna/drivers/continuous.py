"""Runs continuous collision checking over a batch of edges."""

import numpy as np

from ulna.drivers.carried import carried_by
from ulna.drivers.free_edge import edge_is_free, free_until, interval_work
from ulna.engine.decorators import entry
from ulna.engine.signatures import INDICES, MATRIX, NUMBER, NUMBERS, SCENES
from ulna.kernels.collision.ball_motion import world_rounding
from ulna.kernels.collision.collision_layout import EDGE_CONTACT, EDGE_FREE, EDGE_OUT_OF_RANGE
from ulna.kernels.collision.scene import Scene
from ulna.kernels.spatial.elementary import all_in_range


@entry(*((*scene, MATRIX, MATRIX, NUMBER, INDICES, NUMBERS) for scene in SCENES))
def edges_each(
    joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch, q_a, q_b, resolution, status, contact
):
    """Write to status, shape (n,), what the edge from each row of q_a to that of q_b is, and to contact how far it is free.

    EDGE_FREE and 1.0; or EDGE_CONTACT and the fraction of the edge that is free; or EDGE_OUT_OF_RANGE and 0.0.
    """
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch)
    carried, work, of_world = carried_by(scene), interval_work(q_a.shape[1]), world_rounding(scene)
    no_spread = np.zeros(q_a.shape[1])
    for e in range(q_a.shape[0]):
        if not (all_in_range(q_a[e]) and all_in_range(q_b[e])):
            status[e], contact[e] = EDGE_OUT_OF_RANGE, 0.0
        elif edge_is_free(scene, carried, work, q_a[e], q_b[e], no_spread, resolution, 0.0, of_world):
            status[e], contact[e] = EDGE_FREE, 1.0
        else:
            status[e] = EDGE_CONTACT
            contact[e] = free_until(scene, carried, work, q_a[e], q_b[e], resolution, of_world)
    return True
