"""Computes the contacts of chosen pairs."""

import numpy as np

from ulna.engine.decorators import entry
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRIX, NUMBER, NUMBERS, SCENES, TABLE, WHOLE
from ulna.kernels.collision.bvh import FOUND, STACK, bounds_of, rows_within
from ulna.kernels.collision.contacts import write_contact, write_gradient
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import Scene
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.layout import LARGEST
from ulna.kernels.spatial.elementary import all_in_range
from ulna.kernels.spatial.se3 import load_pose


@entry(*((*scene, MATRIX, INDICES, INDEX_ROWS, MATRIX, MATRIX) for scene in SCENES))
def contacts_each(
    joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch, q, rows, candidates, out, gradients
):
    """Write the contact of candidate pair c at q[rows[c]] to row c of out, shape (m, CONTACT_WIDTH). False if q is out of range.

    And to row c of gradients, unless that has no rows, how its distance changes with q: with the normal n from a to b by
    n . (v_b - v_a), where v are the velocities of the witness points as points of their bodies; to first order the witness points
    themselves move along the surfaces only, across n. A candidate of -1 is no pair: its gradient is zero.
    """
    scene = Scene(joints, bodies, vertices, pairs, objects, points, nodes, root, first, end, may_touch)
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    scratch, good, placed = (np.empty(SCRATCH[0]), np.empty(SCRATCH[1]), np.empty(SCRATCH[2])), True, -1
    for c in range(candidates.shape[0]):
        if rows[c] != placed:
            placed = rows[c]
            place_bodies(joints, bodies, q[placed], joint_rows, body_rows)
            good &= all_in_range(q[placed])
        i, j = candidates[c, 0], candidates[c, 1]
        if i >= 0:
            write_contact(scene, body_rows, i, j, scratch, out, c)
        if gradients.shape[0] > 0:
            write_gradient(scene, joint_rows, i, j, out, gradients, c)
    return good


@entry((TABLE, TABLE, MATRIX, WHOLE, NUMBER, NUMBERS, INDEX_ROWS))
def indexed_candidates(joints, bodies, nodes, root, margin, q, out):
    """Write to out, shape (n, 2), bodies and the rows of indexed solids whose bounds are within a margin [m]; return how many.

    There may be more than out has room for: then the rest is counted only.
    """
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    stack, found, count = np.empty(STACK, np.int64), np.empty(FOUND, np.int64), 0
    margin = min(margin, 1e3 * LARGEST)  # with an infinite one absent children would overlap too
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for k in range(bodies.shape[0]):
        low, high = bounds_of(bodies, k, load_pose(body_rows, k))
        low = low[0] - margin, low[1] - margin, low[2] - margin
        high = high[0] + margin, high[1] + margin, high[2] + margin
        stack[0], top = root, 1
        while top > 0:
            n_found, top = rows_within(nodes, (low, high), stack, top, found)
            for i in range(n_found):
                if count < out.shape[0]:
                    out[count, 0], out[count, 1] = k, found[i]
                count += 1
    return count
