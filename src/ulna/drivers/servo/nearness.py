"""Measures the pairs of a scene that are near at one configuration, with the gradients of their distances."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import routine, workspace
from ulna.kernels.collision.bvh import FOUND, STACK, bounds_within, rows_within
from ulna.kernels.collision.collision_layout import CONTACT_WIDTH, DISTANCE
from ulna.kernels.collision.contacts import write_contact, write_gradient
from ulna.kernels.collision.posed_pair import ball_distance, may_touch, place_bodies, rows_gap, solid_at
from ulna.kernels.distance.epa import SCRATCH
from ulna.kernels.servo.servo_layout import MOST_PAIRS
from ulna.kernels.spatial.se3 import load_pose


class Near(NamedTuple):
    """The nearest pairs at a configuration, at most MOST_PAIRS, and room to find them."""

    joint_rows: NDArray
    body_rows: NDArray
    contacts: NDArray
    """One a pair, and one more to work on, shape (MOST_PAIRS + 1, CONTACT_WIDTH)."""
    gradients: NDArray
    """Of the distances, shape (MOST_PAIRS, n_dof) [m/rad or 1]."""
    pairs: NDArray
    """The body and the other body, or the object, numbered from the last body on, shape (MOST_PAIRS, 2)."""
    excess: NDArray
    """How much farther each pair is apart than it has to be [m], by the lower bound of its distance that certificates compute.

    Last the least of all pairs, by their distance. Shape (MOST_PAIRS + 1,).
    """
    stack: NDArray
    found: NDArray
    scratch: tuple


@workspace
def near_of(scene, n_dof):
    """Room for the near pairs of a scene."""
    return Near(
        np.empty(12 * scene.joints.shape[0]), np.empty(12 * scene.bodies.shape[0]),
        np.empty((MOST_PAIRS + 1, CONTACT_WIDTH)), np.empty((MOST_PAIRS, n_dof)), np.empty((MOST_PAIRS, 2), np.int64),
        np.empty(MOST_PAIRS + 1), np.empty(STACK, np.int64), np.empty(FOUND, np.int64),
        (np.empty(SCRATCH[0]), np.empty(SCRATCH[1]), np.empty(SCRATCH[2])),
    )  # fmt: skip


@routine
def measure_near(scene, q, clearance, within, most, near):
    """Find the pairs that are nearer than ``within`` [m] beyond what they have to be: the clearance of objects, 0 of links.

    The nearest of them, ``most`` at the utmost, are written with their gradients. Returns how many these are.
    """
    bodies, n = scene.bodies, scene.bodies.shape[0]
    place_bodies(scene.joints, bodies, q, near.joint_rows, near.body_rows)
    near.excess[MOST_PAIRS], count = within, 0
    for k in range(n):
        for w in range(scene.first, scene.end):
            count = consider(scene, k, n + w, clearance, within, most, near, count)
        if scene.root >= 0:
            bounds, top = bounds_within(bodies, k, load_pose(near.body_rows, k), clearance + within), 1
            near.stack[0] = scene.root
            while top > 0:
                n_found, top = rows_within(scene.nodes, bounds, near.stack, top, near.found)
                for i in range(n_found):
                    count = consider(scene, k, n + near.found[i], clearance, within, most, near, count)
    for p in range(scene.pairs.shape[0]):
        count = consider(scene, scene.pairs[p, 0], scene.pairs[p, 1], 0.0, within, most, near, count)
    for c in range(count):
        write_gradient(scene, near.joint_rows, near.pairs[c, 0], near.pairs[c, 1], near.contacts, near.gradients, c)
    return count


@routine
def consider(scene, i, j, clearance, within, most, near, count):
    """Measure a pair, unless it may touch or its bounding balls are far apart; keep it if it is among the nearest.

    Returns how many are kept.
    """
    bodies, n, a = scene.bodies, scene.bodies.shape[0], load_pose(near.body_rows, i)
    if j < n:
        row, b = j, load_pose(near.body_rows, j)
        others, points = bodies, scene.vertices
    else:
        row, b = solid_at(scene, j - n, 0.0)
        if may_touch(scene, i, row):
            return count
        others, points = scene.objects, scene.points
    if ball_distance(bodies, i, a, others, row, b) - clearance >= within:
        return count
    write_contact(scene, near.body_rows, i, j, near.scratch, near.contacts, MOST_PAIRS)
    distance = near.contacts[MOST_PAIRS, DISTANCE]
    near.excess[MOST_PAIRS] = min(near.excess[MOST_PAIRS], distance - clearance)
    if distance - clearance >= within or most == 0:
        return count
    gap = rows_gap(bodies, scene.vertices, i, a, others, points, row, b, clearance + within, 0.0)
    excess = min(gap, distance) - clearance
    slot = count
    if count == most:
        slot = 0
        for c in range(1, count):
            if near.excess[c] > near.excess[slot]:
                slot = c
        if near.excess[slot] <= excess:
            return count
        count -= 1
    near.pairs[slot, 0], near.pairs[slot, 1], near.excess[slot] = i, j, excess
    for c in range(CONTACT_WIDTH):
        near.contacts[slot, c] = near.contacts[MOST_PAIRS, c]
    return count + 1
