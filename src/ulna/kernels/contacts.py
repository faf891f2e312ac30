"""Contacts: the signed distance, the witness points and the normal of chosen pairs at one q."""

import numpy as np

from ulna.kernels.block import all_in_range
from ulna.kernels.compile import entry, kernel
from ulna.kernels.lanes import load
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
    n = bodies.shape[0]
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * n)
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for c in range(candidates.shape[0]):
        a, j = robot_body(bodies, vertices, candidates[c, 0], body_rows), candidates[c, 1]
        if j < n:
            write_contact(pair_distance(a, robot_body(bodies, vertices, j, body_rows)), out[c])
        else:
            write_contact(pair_distance(a, world_body(objects, points, j - n, load(q, 0))), out[c])
    return all_in_range(q)


@kernel
def write_contact(answer, out):
    """Write an answer in plain numbers to a row."""
    distance, p, q, n = answer
    out[DISTANCE] = distance
    out[WITNESS_A], out[WITNESS_A + 1], out[WITNESS_A + 2] = p
    out[WITNESS_B], out[WITNESS_B + 1], out[WITNESS_B + 2] = q
    out[NORMAL], out[NORMAL + 1], out[NORMAL + 2] = n
