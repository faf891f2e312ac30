"""Groups the bodies of a scene by the joint that carries them, for edge checks."""

import numpy as np

from ulna.engine.decorators import routine, workspace
from ulna.engine.lanes import empty_rows
from ulna.kernels.collision.ball_motion import offset_length
from ulna.kernels.collision.collision_layout import (
    BALL_CENTER,
    BALL_JOINT,
    BALL_LENGTH,
    BALL_RADIUS,
    BALL_WIDTH,
    GROUP_A,
    GROUP_B,
    GROUP_END,
    GROUP_FIRST,
    GROUP_SHARED,
    GROUP_WIDTH,
    RUN_BODY,
    RUN_END,
    RUN_FIRST,
    RUN_WIDTH,
    STEP_LENGTH,
    STEP_WIDTH,
)
from ulna.kernels.collision.scene import Carried
from ulna.kernels.layout import BASE, JOINT, PARENT, REACH


@workspace
def carried_by(scene):
    """Group the bodies of a scene into one ball per joint, with room for an edge.

    Each thread needs one of these, for any number of edges.
    """
    n_joints = scene.joints.shape[0]
    balls, order, first = balls_of(scene.bodies, n_joints)
    groups, runs, others = groups_of(scene.joints, scene.bodies, scene.pairs, balls)
    n_balls = balls.shape[0]
    return Carried(
        balls, order, first, groups, runs, others, steps_of(scene.joints),
        np.empty((n_balls, n_joints + 1)), np.empty((n_balls, n_joints + 1)), np.empty(n_balls),
        empty_rows(12 * n_joints), empty_rows(6 * n_joints), empty_rows(7 * n_balls),
        empty_rows(3 * scene.bodies.shape[0]), np.zeros(n_balls, np.int64), np.empty(scene.end - scene.first, np.int64),
    )  # fmt: skip


@workspace
def steps_of(joints):
    """Room for the joints along an edge, with the values that are the same for all edges."""
    steps = np.empty((joints.shape[0], STEP_WIDTH))
    for i in range(joints.shape[0]):
        steps[i, STEP_LENGTH] = offset_length(joints, i)
    return steps


@workspace
def balls_of(bodies, n_joints):
    """A ball for each joint with bodies, the bodies in the order of their balls, and each ball's first body."""
    counts = np.zeros(n_joints + 2, np.int64)
    for k in range(bodies.shape[0]):
        counts[int(bodies[k, JOINT]) + 2] += 1
    starts = np.cumsum(counts)
    order, filled = np.empty(bodies.shape[0], np.int64), starts.copy()
    for k in range(bodies.shape[0]):
        joint = int(bodies[k, JOINT]) + 1
        order[filled[joint]] = k
        filled[joint] += 1
    n_balls = np.count_nonzero(counts)
    balls, first = np.zeros((n_balls, BALL_WIDTH)), np.zeros(n_balls + 1, np.int64)
    g = 0
    for joint in range(n_joints + 1):
        if counts[joint + 1] > 0:
            first[g], first[g + 1] = starts[joint], starts[joint + 1]
            write_ball(bodies, order, joint - 1, first, g, balls)
            g += 1
    return balls, order, first


@routine
def write_ball(bodies, order, joint, first, g, balls):
    """Write a ball that holds the bodies of a joint, centered in the AABB of their bounding balls."""
    balls[g, BALL_JOINT] = joint
    for axis in range(3):
        low, high = np.inf, -np.inf
        for m in range(first[g], first[g + 1]):
            x, reach = bodies[order[m], 4 * axis + 3], bodies[order[m], REACH]
            low, high = min(low, x - reach), max(high, x + reach)
        balls[g, BALL_CENTER + axis] = 0.5 * (low + high)
    for m in range(first[g], first[g + 1]):
        k, square = order[m], 0.0
        for axis in range(3):
            d = bodies[k, 4 * axis + 3] - balls[g, BALL_CENTER + axis]
            square += d * d
        balls[g, BALL_RADIUS] = max(balls[g, BALL_RADIUS], np.sqrt(square) + bodies[k, REACH])
    x, y, z = balls[g, BALL_CENTER], balls[g, BALL_CENTER + 1], balls[g, BALL_CENTER + 2]
    balls[g, BALL_LENGTH] = balls[g, BALL_RADIUS] + np.sqrt(x * x + y * y + z * z)


@workspace
def groups_of(joints, bodies, pairs, balls):
    """The pairs grouped by their two balls, the larger ball first, and by their body in it (``scene.Carried``)."""
    n_balls, n = balls.shape[0], pairs.shape[0]
    number = np.zeros(joints.shape[0] + 1, np.int64)
    for g in range(n_balls):
        number[int(balls[g, BALL_JOINT]) + 1] = g
    bodies_of_pairs, group = np.empty((2, n), np.int64), np.empty(n, np.int64)
    for p in range(n):
        i, j = pairs[p, 0], pairs[p, 1]
        a, b = number[int(bodies[i, JOINT]) + 1], number[int(bodies[j, JOINT]) + 1]
        if balls[a, BALL_RADIUS] < balls[b, BALL_RADIUS]:
            a, b, i, j = b, a, j, i
        bodies_of_pairs[0, p], bodies_of_pairs[1, p], group[p] = i, j, a * n_balls + b
    order = counted_order(bodies_of_pairs[0], bodies.shape[0], np.arange(n))
    order = counted_order(group, n_balls * n_balls, order)
    groups, runs, others = np.empty((min(n, n_balls * n_balls), GROUP_WIDTH), np.int64), np.empty((n, RUN_WIDTH), np.int64), order
    n_groups, n_runs, before, body = 0, 0, -1, -1
    for at in range(n):
        p = order[at]
        if group[p] != before:
            before, body = group[p], -1
            a, b = before // n_balls, before % n_balls
            groups[n_groups, GROUP_A], groups[n_groups, GROUP_B], groups[n_groups, GROUP_FIRST] = a, b, n_runs
            groups[n_groups, GROUP_SHARED] = shared_joint(joints, int(balls[a, BALL_JOINT]), int(balls[b, BALL_JOINT]))
            n_groups += 1
        if bodies_of_pairs[0, p] != body:
            body = bodies_of_pairs[0, p]
            runs[n_runs, RUN_BODY], runs[n_runs, RUN_FIRST] = body, at
            n_runs += 1
        runs[n_runs - 1, RUN_END], groups[n_groups - 1, GROUP_END], others[at] = at + 1, n_runs, bodies_of_pairs[1, p]
    return groups[:n_groups], runs[:n_runs], others


@workspace
def counted_order(keys, n_keys, order):
    """An order sorted by keys below n_keys. Entries with equal keys keep their order (counting sort)."""
    starts, result = np.zeros(n_keys + 1, np.int64), np.empty_like(order)
    for p in range(keys.shape[0]):
        starts[keys[p] + 1] += 1
    for k in range(n_keys):
        starts[k + 1] += starts[k]
    for p in order:
        result[starts[keys[p]]] = p
        starts[keys[p]] += 1
    return result


@routine
def shared_joint(joints, i, j):
    """The last joint that carries both joints, or is one of them; BASE if none does.

    Parents come before children.
    """
    while i != j:
        if i > j:
            i = int(joints[i, PARENT])
        else:
            j = int(joints[j, PARENT])
    return max(i, BASE)
