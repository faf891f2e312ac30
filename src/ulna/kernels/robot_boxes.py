"""The robot's boxes against the world's: poses from the tree, then every pair through the separating-axis test."""

import numpy as np

from ulna.kernels.block import all_in_range, gather
from ulna.kernels.box_box import boxes_overlap, widest_gap
from ulna.kernels.compile import entry, kernel
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.layout import HALF_EXTENTS
from ulna.kernels.se3 import constant_pose
from ulna.kernels.tree import frame_pose, tree_poses
from ulna.kernels.vectors import cross

FREE, OVERLAPS, OUT_OF_RANGE = 0, 1, 2


@kernel
def half_extents(boxes, k, like):
    """The half extents of box k as three numbers."""
    column = HALF_EXTENTS
    return splat(boxes[k, column], like), splat(boxes[k, column + 1], like), splat(boxes[k, column + 2], like)


@kernel
def box_hits(boxes, k, joint_rows, world, like):
    """1.0 where box k of the robot overlaps any box of the world, 0.0 elsewhere."""
    pose, half = frame_pose(boxes, k, joint_rows, like), half_extents(boxes, k, like)
    hits = splat(0.0, like)
    for w in range(world.shape[0]):
        overlap = boxes_overlap(pose, half, constant_pose(world, w, like), half_extents(world, w, like))
        hits = where(overlap, 1.0, hits)
    return hits


@entry
def overlap_one(joints, boxes, world, q):
    """FREE or OVERLAPS for one q, at the first box found; OUT_OF_RANGE if an entry of q is."""
    if not all_in_range(q):
        return OUT_OF_RANGE
    joint_rows = np.empty(12 * joints.shape[0])
    tree_poses(joints, q, joint_rows)
    for k in range(boxes.shape[0]):
        if any_lane(box_hits(boxes, k, joint_rows, world, load(q, 0)) > 0.0):
            return OVERLAPS
    return FREE


@entry
def overlap_batch(joints, boxes, world, q, out):
    """Write to the bools of out, shape (n,), whether the robot overlaps the world. False if an entry of q is out of range."""
    n = q.shape[0]
    q_rows, hit_rows = np.zeros((max(1, q.shape[1]), WIDTH)), np.empty((1, WIDTH))
    joint_rows = np.empty((12 * joints.shape[0], WIDTH))
    good = True
    for start in range(0, n, WIDTH):
        gather(q, start, q_rows)
        good &= all_in_range(q_rows)
        tree_poses(joints, q_rows, joint_rows)
        hits = splat(0.0, load(q_rows, 0))
        for k in range(boxes.shape[0]):
            hits = hits + box_hits(boxes, k, joint_rows, world, load(q_rows, 0))
        store(hit_rows, 0, hits)
        for lane in range(WIDTH):
            out[min(start + lane, n - 1)] = hit_rows[0, lane] > 0.0
    return good


@entry
def gaps_one(joints, boxes, world, q, gaps, normals):
    """The widest gap of every pair for one q: gaps of shape (n_boxes, n_world), normals (n_boxes, n_world, 3).

    A normal points from the robot's box to the world's along the axis of the gap. False if an entry of q is out of range.
    """
    like = load(q, 0)
    joint_rows = np.empty(12 * joints.shape[0])
    tree_poses(joints, q, joint_rows)
    for k in range(boxes.shape[0]):
        a, h = frame_pose(boxes, k, joint_rows, like), half_extents(boxes, k, like)
        for w in range(world.shape[0]):
            b, g = constant_pose(world, w, like), half_extents(world, w, like)
            gaps[k, w], axis = widest_gap(a, h, b, g)
            normals[k, w, 0], normals[k, w, 1], normals[k, w, 2] = axis_direction(a, b, int(axis))
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
