"""Contacts: the signed distance, the witness points and the normal of chosen pairs, and how the distance changes with q.

A pair is a body of the robot and another, or an object of the world, numbered from the last body on.
"""

import numpy as np

from ulna.kernels.block import all_in_range
from ulna.kernels.bounds import STACK, bounds_of, objects_within
from ulna.kernels.compile import entry, kernel
from ulna.kernels.depth import SCRATCH
from ulna.kernels.kinds import INDEX_ROWS, INDICES, MATRIX, NUMBER, NUMBERS, SCENES, TABLE, WHOLE
from ulna.kernels.layout import COLUMN, JOINT, KIND, LARGEST, PARENT, PRISMATIC, RATIO
from ulna.kernels.placed import place_bodies, rows_answer
from ulna.kernels.se3 import constant_pose, load_pose
from ulna.kernels.vectors import axis, cross, dot, minus, origin

# Columns of an answer.
DISTANCE, WITNESS_A, WITNESS_B, NORMAL = 0, 1, 4, 7
CONTACT_WIDTH = 10


@entry(*((*scene[:3], *scene[4:6], MATRIX, INDICES, INDEX_ROWS, MATRIX, MATRIX) for scene in SCENES))
def contacts_each(joints, bodies, vertices, objects, points, q, rows, candidates, out, gradients):
    """Write the answer for candidate pair c at q[rows[c]] to row c of out, shape (m, CONTACT_WIDTH). False if q is out of range.

    And to row c of gradients, unless that has no rows, how its distance changes with q: with the normal n from a to b by
    n . (v_b - v_a), where v are the velocities of the witness points as points of their bodies; to first order the witness points
    themselves move along the surfaces only, across n. A candidate of -1 is no pair: its gradient is zero.
    """
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    scratch, good, placed = (np.empty(SCRATCH[0]), np.empty(SCRATCH[1]), np.empty(SCRATCH[2])), True, -1
    for c in range(candidates.shape[0]):
        if rows[c] != placed:
            placed = rows[c]
            place_bodies(joints, bodies, q[placed], joint_rows, body_rows)
            good &= all_in_range(q[placed])
        i, j = candidates[c, 0], candidates[c, 1]
        if i >= 0:
            write_contact(bodies, vertices, body_rows, objects, points, i, j, scratch, out, c)
        if gradients.shape[0] > 0:
            write_gradient(joints, bodies, joint_rows, i, j, out, gradients, c)
    return good


@kernel
def write_contact(bodies, vertices, body_rows, objects, points, i, j, scratch, out, row):
    """Write the answer for a pair, in plain numbers, to a row of out."""
    a, n = load_pose(body_rows, i), bodies.shape[0]
    if j < n:
        distance, p, q, normal = rows_answer(bodies, vertices, i, a, bodies, vertices, j, load_pose(body_rows, j), scratch)
    else:
        b = constant_pose(objects, j - n, 0.0)
        distance, p, q, normal = rows_answer(bodies, vertices, i, a, objects, points, j - n, b, scratch)
    out[row, DISTANCE] = distance
    out[row, WITNESS_A], out[row, WITNESS_A + 1], out[row, WITNESS_A + 2] = p
    out[row, WITNESS_B], out[row, WITNESS_B + 1], out[row, WITNESS_B + 2] = q
    out[row, NORMAL], out[row, NORMAL + 1], out[row, NORMAL + 2] = normal


@kernel
def write_gradient(joints, bodies, joint_rows, i, j, contacts, out, row):
    """Write the gradient of the distance of a pair to a row of out."""
    for k in range(out.shape[1]):
        out[row, k] = 0.0
    if i >= 0:
        add_speeds(joints, joint_rows, int(bodies[i, JOINT]), contacts, row, WITNESS_A, -1.0, out)
        if j < bodies.shape[0]:
            add_speeds(joints, joint_rows, int(bodies[j, JOINT]), contacts, row, WITNESS_B, 1.0, out)


@kernel
def add_speeds(joints, joint_rows, joint, contacts, row, witness, sign, out):
    """Add to a row of out, for each entry of q, sign times the speed along the normal of a witness point moved by a joint."""
    point = contacts[row, witness], contacts[row, witness + 1], contacts[row, witness + 2]
    normal = contacts[row, NORMAL], contacts[row, NORMAL + 1], contacts[row, NORMAL + 2]
    while joint >= 0:
        pose = load_pose(joint_rows, joint)
        z = axis(pose, 2)
        if int(joints[joint, KIND]) != PRISMATIC:
            z = cross(z, minus(point, origin(pose)))
        out[row, int(joints[joint, COLUMN])] += sign * joints[joint, RATIO] * dot(normal, z)
        joint = int(joints[joint, PARENT])


@entry((TABLE, TABLE, MATRIX, WHOLE, NUMBER, NUMBERS, INDEX_ROWS))
def candidates_hung(joints, bodies, nodes, n_hung, margin, q, out):
    """Write to out, shape (n, 2), the bodies and the objects of the tree whose bounds are within a margin [m]; return how many.

    The objects are numbered from 0. There may be more than out has room for: then the rest is counted only.
    """
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * bodies.shape[0])
    stack, found, count = np.empty(STACK, np.int64), np.empty(n_hung, np.int64), 0
    margin = min(margin, 1e3 * LARGEST)  # an infinite one would meet the children that are not there
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for k in range(bodies.shape[0]):
        low, high = bounds_of(bodies, k, load_pose(body_rows, k))
        low = low[0] - margin, low[1] - margin, low[2] - margin
        high = high[0] + margin, high[1] + margin, high[2] + margin
        for i in range(objects_within(nodes, n_hung, (low, high), stack, found)):
            if count < out.shape[0]:
                out[count, 0], out[count, 1] = k, found[i]
            count += 1
    return count
