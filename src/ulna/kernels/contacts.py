"""Contacts: the signed distance, the witness points and the normal of chosen pairs at one q."""

import numpy as np

from ulna.kernels.block import all_in_range
from ulna.kernels.compile import entry, routine
from ulna.kernels.depth import SCRATCH
from ulna.kernels.pair import pair_distance
from ulna.kernels.placed import place_bodies, robot_body, world_body

# Columns of an answer.
DISTANCE, WITNESS_A, WITNESS_B, NORMAL = 0, 1, 4, 7
CONTACT_WIDTH = 10


@entry
def contacts_one(joints, bodies, vertices, objects, points, candidates, q, out):
    """Write the answer for each candidate pair at q to a row of out, shape (n, CONTACT_WIDTH).

    A candidate is a body of the robot and another, or an object of the world, numbered from the last body on. False if an entry
    of q is out of range.
    """
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    scratch = np.empty(SCRATCH[0]), np.empty(SCRATCH[1]), np.empty(SCRATCH[2])
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for c in range(candidates.shape[0]):
        write_contact(bodies, vertices, body_rows, objects, points, candidates[c, 0], candidates[c, 1], scratch, out, c)
    return all_in_range(q)


@routine
def write_contact(bodies, vertices, body_rows, objects, points, i, j, scratch, out, row):
    """Write the answer for a candidate pair, in plain numbers, to a row of out."""
    a, n = robot_body(bodies, vertices, i, body_rows), bodies.shape[0]
    if j < n:
        distance, p, q, normal = pair_distance(a, robot_body(bodies, vertices, j, body_rows), scratch)
    else:
        distance, p, q, normal = pair_distance(a, world_body(objects, points, j - n, body_rows[0]), scratch)
    out[row, DISTANCE] = distance
    for k in range(3):
        out[row, WITNESS_A + k], out[row, WITNESS_B + k], out[row, NORMAL + k] = p[k], q[k], normal[k]
