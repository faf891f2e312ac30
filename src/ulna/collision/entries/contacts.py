"""Computes the contacts of given pairs, and the contacts of all pairs that are near each other."""

import numpy as np

from ulna.engine.decorators import entry, kernel, workspace
from ulna.engine.signatures import INDEX_ROWS, INDICES, MATRIX, NUMBER, WHOLE, Group
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import CONTACT_WIDTH, PAIR_BODY, PAIR_OTHER, PAIR_WIDTH, PLANE_WIDTH, PLANES
from ulna.kernels.collision.contacts import copy_row, find_near_pairs, order_of_rows, write_contact, write_gradient
from ulna.kernels.collision.posed_pair import place_bodies
from ulna.kernels.collision.scene import BOXES, SHAPES, Near, NearPairs, Planes
from ulna.kernels.distance.epa import EDGES, FACES, points_needed
from ulna.kernels.distance.epa_polytope import FACE_WIDTH, POINT_WIDTH
from ulna.kernels.spatial.elementary import all_in_range

_FOUND = Group((INDICES, INDEX_ROWS, MATRIX, MATRIX), NearPairs)


@entry(*((scene, MATRIX, INDICES, INDEX_ROWS, MATRIX, MATRIX) for scene in (BOXES, SHAPES)))
def contacts_each(scene, q, rows, candidates, out, gradients):
    """Write the contact of candidate pair c at q[rows[c]] to row c of out, shape (m, CONTACT_WIDTH).

    If gradients has rows, write the derivative of its distance with respect to q to row c: n . (v_b - v_a), with the normal n
    from a to b. v_a and v_b are the velocities of the witness points as points of their bodies. To first order, the witness
    points move along the surfaces only, across n.

    A candidate of -1 is no pair: its gradient is zero. Returns False if an entry of q is out of range.
    """
    near, good, placed = near_of(scene, 0, 0), True, -1
    for c in range(candidates.shape[0]):
        if rows[c] != placed:
            placed = rows[c]
            place_bodies(scene.joints, scene.bodies, q[placed], near.joint_rows, near.body_rows)
            good &= all_in_range(q[placed])
        i, j = candidates[c, 0], candidates[c, 1]
        if i >= 0:
            write_contact(scene, near.body_rows, i, j, near.scratch, out, c)
        if gradients.shape[0] > 0:
            write_gradient(scene, near.joint_rows, i, j, out, gradients, c)
    return good


@entry(*((scene, WHOLE, MATRIX, NUMBER, _FOUND) for scene in (BOXES, SHAPES)))
def near_each(scene, n_objects, q, within, found):
    """Write the pairs at most ``within`` [m] apart at each q, grouped by q, the nearest first.

    n_objects: An upper bound on the object numbers. Of an object of many solids only the solid nearest to each body is written;
    with n_objects 0, all of its solids.

    found: The ``NearPairs`` to write to. Its number of rows is the room. Gradients without rows are not computed. ``ends`` is -1
    where there was no room. Returns False if an entry of q is out of range.
    """
    room = found.pairs.shape[0]
    near, order = near_of(scene, room, n_objects), np.empty(room, np.int64)
    count, good = 0, True
    for i in range(q.shape[0]):
        good &= all_in_range(q[i])
        found.ends[i] = -1
        if count < 0:
            continue
        place_bodies(scene.joints, scene.bodies, q[i], near.joint_rows, near.body_rows)
        for k in range(scene.bodies.shape[0]):
            near.planes.counts[k] = 0  # rows of a batch are independent
        n = find_near_pairs(scene, 0.0, None, within, near, None)
        if count + n <= room:
            found.ends[i] = count + n
            order_of_rows(near.contact_rows, n, order)
            for k in range(n):
                copy_row(near.contact_rows, order[k], found.contacts, count + k)
                copy_row(near.pair_rows, order[k], found.pairs, count + k)
                if found.gradients.shape[0] > 0:
                    body, other = found.pairs[count + k, PAIR_BODY], found.pairs[count + k, PAIR_OTHER]
                    write_gradient(scene, near.joint_rows, body, other, found.contacts, found.gradients, count + k)
        count = found.ends[i]
    return good


@workspace
def scratch_of_epa(scene):
    """The arrays that EPA writes to: points, faces and edges, sized for the polytopes of the scene's shapes.

    They are no larger: the memory of large arrays returns to the system after each call, which takes longer than the call.
    """
    n = points_needed(row_count(scene.vertices), row_count(scene.points))
    return np.empty((n, POINT_WIDTH)), np.empty((FACES * n, FACE_WIDTH)), np.empty((EDGES * n, 2))


@kernel
def row_count(vertices):
    """The number of vertices; 0 if the vertices are None, since all shapes are boxes."""
    if vertices is None:
        return 0
    return vertices.shape[0]


@workspace
def near_of(scene, room, n_objects):
    """Room for this many near pairs of a scene."""
    return Near(
        np.empty(12 * scene.joints.shape[0]), np.empty(12 * scene.bodies.shape[0]),
        np.empty((room + 1, CONTACT_WIDTH)), np.empty((room, PAIR_WIDTH), np.int64), np.empty(n_objects, np.int64),
        np.empty(STACK, np.int64), np.empty(STACK), np.empty(0),
        Planes(np.empty((PLANES * scene.bodies.shape[0], PLANE_WIDTH)), np.zeros(scene.bodies.shape[0], np.int64)),
        scratch_of_epa(scene),
    )  # fmt: skip
