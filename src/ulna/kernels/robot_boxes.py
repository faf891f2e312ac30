"""Boxes out of tables, pair by pair, and the depths of all pairs of the robot's boxes and the world's."""

import numpy as np

from ulna.kernels.block import all_in_range
from ulna.kernels.box_box import boxes_overlap, widest_gap
from ulna.kernels.compile import entry, kernel
from ulna.kernels.jacobian import cross
from ulna.kernels.lanes import load, splat
from ulna.kernels.layout import HALF_EXTENTS
from ulna.kernels.placed import place_bodies
from ulna.kernels.se3 import constant_pose, load_pose


@kernel
def half_extents(boxes, k, like):
    """The half extents of box k as three numbers."""
    column = HALF_EXTENTS
    return splat(boxes[k, column], like), splat(boxes[k, column + 1], like), splat(boxes[k, column + 2], like)


@kernel
def pair_overlaps(bodies_a, i, a, bodies_b, j, b):
    """True where body i of one table, at pose a, and body j of another, at pose b, share a point."""
    return boxes_overlap(a, half_extents(bodies_a, i, a[0]), b, half_extents(bodies_b, j, a[0]))


@entry
def contacts_one(joints, bodies, objects, candidates, q, out):
    """The widest gap of each candidate pair for one q and its axis, from a to b: out of shape (n, 4).

    A candidate is a body of the robot and another, or an object of the world, numbered from the last body on. False if an entry
    of q is out of range.
    """
    n, like = bodies.shape[0], load(q, 0)
    joint_rows, body_rows = np.empty(12 * joints.shape[0]), np.empty(12 * n)
    place_bodies(joints, bodies, q, joint_rows, body_rows)
    for c in range(candidates.shape[0]):
        i, j = candidates[c, 0], candidates[c, 1]
        a, h = load_pose(body_rows, i), half_extents(bodies, i, like)
        if j < n:
            b, g = load_pose(body_rows, j), half_extents(bodies, j, like)
        else:
            b, g = constant_pose(objects, j - n, like), half_extents(objects, j - n, like)
        out[c, 0], axis = widest_gap(a, h, b, g)
        out[c, 1], out[c, 2], out[c, 3] = axis_direction(a, b, int(axis))
    return all_in_range(q)


@kernel
def axis_direction(a, b, axis):
    """The unit vector of one of the fifteen axes, pointing from box a to box b. For one pair: it branches."""
    if axis < 3:
        n = (a[axis], a[4 + axis], a[8 + axis])
    elif axis < 6:
        n = (b[axis - 3], b[1 + axis], b[5 + axis])
    else:
        i, j = (axis - 6) // 3, (axis - 6) % 3
        n = cross((a[i], a[4 + i], a[8 + i]), (b[j], b[4 + j], b[8 + j]))
    towards = n[0] * (b[3] - a[3]) + n[1] * (b[7] - a[7]) + n[2] * (b[11] - a[11])
    scale = (-1.0 if towards < 0.0 else 1.0) / np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    return n[0] * scale, n[1] * scale, n[2] * scale
