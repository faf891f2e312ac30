"""Decides whether an edge is free, breadth first, eight intervals at a time. Used by ``continuous`` and ``planning``.

1. Eight intervals cover the edge. If something touches at the middle of any (``kernels.collision.interval``), it is not free.
2. An interval that is not clear throughout is split: one into eight, two into four each, up to four into two each, so that the
   lanes are filled. The oldest go first: what touches in the middle of an edge is found before its ends are looked at closely.
3. The edge is free when no interval is left. One so short that nothing moves by the resolution in it is not split further, and
   the edge is not free; nor is it if a given number of blocks of eight does not suffice.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine, shared_routine, workspace
from ulna.engine.lanes import empty_rows, load, store, zero_rows
from ulna.engine.width import WIDTH
from ulna.kernels.collision.ball_motion import fastest_ball, place_balls, write_motion
from ulna.kernels.collision.bvh import STACK
from ulna.kernels.collision.collision_layout import (
    BALL_CENTRE,
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
from ulna.kernels.collision.continuous import INSTANT, offset_length
from ulna.kernels.collision.interval import self_outcome, world_outcome
from ulna.kernels.collision.scene import Carried
from ulna.kernels.layout import BASE, JOINT, PARENT, REACH

MOST_BLOCKS = 256  # of eight intervals of an edge
MOST_WAITING = MOST_BLOCKS * WIDTH + 1


@workspace
def free_edge_work(scene, may_touch):
    """The bodies of a scene by ball, with room for an edge: one per thread is enough for any number of edges.

    may_touch: whether a body may touch an unindexed object, shape (n_bodies, n_unindexed).
    """
    n_joints = scene.joints.shape[0]
    balls, order, first = balls_of(scene.bodies, n_joints)
    groups, runs, others = groups_of(scene.joints, scene.bodies, scene.pairs, balls)
    n_balls = balls.shape[0]
    return Carried(
        balls, order, first, groups, runs, others, may_touch, steps_of(scene.joints),
        np.empty((n_balls, n_joints + 1)), np.empty((n_balls, n_joints + 1)), np.empty(n_balls),
        empty_rows(12 * n_joints), empty_rows(6 * n_joints), empty_rows(7 * n_balls),
        empty_rows(3 * scene.bodies.shape[0]), np.zeros(n_balls, np.int64), np.empty(scene.objects.shape[0], np.int64),
    )  # fmt: skip


@workspace
def interval_work(scene, n_dof):
    """Configurations, middles and halves of eight intervals; those that wait; the stack and the finds of the BVH."""
    n_indexed = scene.objects.shape[0] - scene.n_unindexed
    return (
        zero_rows(max(1, n_dof)),
        empty_rows(3),
        np.empty((MOST_WAITING, 2)),
        np.empty(STACK, np.int64),
        np.empty(n_indexed, np.int64),
    )


@workspace
def steps_of(joints):
    """Room for the joints along an edge, with what is so for all edges."""
    steps = np.empty((joints.shape[0], STEP_WIDTH))
    for i in range(joints.shape[0]):
        steps[i, STEP_LENGTH] = offset_length(joints, i)
    return steps


@workspace
def balls_of(bodies, n_joints):
    """A ball for each joint that carries bodies, the bodies in their order, and where those of each ball begin."""
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
    """Write a ball that holds the bodies of a joint: about the middle of the AABB of their own balls."""
    balls[g, BALL_JOINT] = joint
    for axis in range(3):
        low, high = np.inf, -np.inf
        for m in range(first[g], first[g + 1]):
            x, reach = bodies[order[m], 4 * axis + 3], bodies[order[m], REACH]
            low, high = min(low, x - reach), max(high, x + reach)
        balls[g, BALL_CENTRE + axis] = 0.5 * (low + high)
    for m in range(first[g], first[g + 1]):
        k, square = order[m], 0.0
        for axis in range(3):
            d = bodies[k, 4 * axis + 3] - balls[g, BALL_CENTRE + axis]
            square += d * d
        balls[g, BALL_RADIUS] = max(balls[g, BALL_RADIUS], np.sqrt(square) + bodies[k, REACH])
    x, y, z = balls[g, BALL_CENTRE], balls[g, BALL_CENTRE + 1], balls[g, BALL_CENTRE + 2]
    balls[g, BALL_LENGTH] = balls[g, BALL_RADIUS] + np.sqrt(x * x + y * y + z * z)


@workspace
def groups_of(joints, bodies, pairs, balls):
    """The pairs by the two balls that they belong to, the larger one first, and by their body in it (``scene.Carried``)."""
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
    """An order of things, by their keys below n_keys; those of one key stay as they are in it."""
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
    """The last joint that carries both of two joints, or is one of them; BASE if none does. Parents come before children."""
    while i != j:
        if i > j:
            i = int(joints[i, PARENT])
        else:
            j = int(joints[j, PARENT])
    return max(i, BASE)


@kernel
def edge_is_free(scene, carried, work, q_a, q_b, spread, resolution, margin, of_world, most_blocks):
    """Whether the edge from q_a to q_b is certainly free, and nothing of the world is nearer than a margin [m].

    With a spread above 0, (n_dof,), that holds for all that lies so far beside the edge in each entry of q.
    of_world: ``world_rounding(scene)``; most_blocks: of eight intervals, at most ``MOST_BLOCKS``. q_a and q_b are in range.
    """
    _, lane_rows, waiting, _, _ = work
    write_motion(scene.joints, q_a, q_b, spread, carried)
    fastest = fastest_ball(scene.joints, carried)
    waiting[0, 0], waiting[0, 1] = 0.5, 0.5
    oldest, newest = 0, 1
    for _ in range(most_blocks):
        n, shortest = split_oldest(waiting, oldest, newest, lane_rows)
        oldest += n
        if outcome_at(scene, carried, work, q_a, q_b, INSTANT, 2.0 * shortest * fastest <= resolution, margin, of_world):
            return False
        for lane in range(WIDTH // n * n):
            if lane_rows[2, lane] == 0.0:
                if 2.0 * lane_rows[1, lane] * fastest <= resolution or newest == MOST_WAITING:
                    return False
                waiting[newest, 0], waiting[newest, 1] = lane_rows[0, lane], lane_rows[1, lane]
                newest += 1
        if oldest == newest:
            return True
    return False


@routine
def split_oldest(waiting, oldest, newest, lane_rows):
    """Write the middles and half lengths of eight intervals, the parts of the n oldest that wait; n, and the least half length.

    The last of them are repeats where n does not divide eight.
    """
    n, shortest = min(newest - oldest, WIDTH // 2), 1.0
    share = WIDTH // n
    for lane in range(WIDTH):
        i, part = min(lane // share, n - 1), lane % share
        middle, half = waiting[oldest + i, 0], waiting[oldest + i, 1] / share
        lane_rows[0, lane], lane_rows[1, lane] = middle + (2 * part + 1 - share) * half, half
        shortest = min(shortest, half)
    return n, shortest


@shared_routine
def outcome_at(scene, carried, work, q_a, q_b, instant, finest, margin, of_world):
    """Whether something touches at the middles of eight intervals; which of them are clear is written to ``lane_rows``.

    instant: what is added to their half lengths; 0 if these are 0, so that nothing moves.
    """
    q_rows, lane_rows, _, stack, found = work
    t, half = load(lane_rows, 0), load(lane_rows, 1) + instant
    for k in range(q_a.shape[0]):
        store(q_rows, k, t * (q_b[k] - q_a[k]) + q_a[k])
    like = load(q_rows, 0)
    still = instant == 0.0
    place_balls(scene.joints, q_rows, half, still, carried)
    touches, clear = world_outcome(scene, carried, half, still, margin, of_world, finest, stack, found, like)
    if touches:
        return True
    touches, clear = self_outcome(scene, carried, half, still, clear, like)
    store(lane_rows, 2, clear)
    return touches


@kernel
def edge_is_free_at_samples(scene, carried, work, q_a, q_b, spread, n_blocks, margin, of_world):
    """Whether the robot is free at 8 n_blocks evenly spaced configurations of an edge, the last of them q_b.

    Those in an interval that is certified need no look of their own. Intervals are looked at as in ``edge_is_free``, as long as
    the last look settled more samples than it has lanes.
    """
    _, lane_rows, waiting, _, _ = work
    write_motion(scene.joints, q_a, q_b, spread, carried)
    waiting[0, 0], waiting[0, 1] = 0.5, 0.5
    oldest, newest, left, settled = 0, 1, WIDTH * n_blocks, WIDTH + 1
    while left > WIDTH and settled > WIDTH and newest + WIDTH <= MOST_WAITING:
        n, _ = split_oldest(waiting, oldest, newest, lane_rows)
        oldest, before, left = oldest + n, left, 0
        if outcome_at(scene, carried, work, q_a, q_b, INSTANT, n_blocks <= 0, margin, of_world):
            return False
        for lane in range(WIDTH // n * n):
            if lane_rows[2, lane] == 0.0:
                waiting[newest, 0], waiting[newest, 1] = lane_rows[0, lane], lane_rows[1, lane]
                newest += 1
        for i in range(oldest, newest):
            first, end = samples_in(waiting, i, n_blocks)
            left += end - first
        settled = before - left
    n = 0
    for i in range(oldest, newest):
        first, end = samples_in(waiting, i, n_blocks)
        for sample in range(first, end):
            lane_rows[0, n] = sample / (WIDTH * n_blocks)
            n += 1
            if n == WIDTH:
                if touches_at(scene, carried, work, q_a, q_b, n, margin, of_world):
                    return False
                n = 0
    return n == 0 or not touches_at(scene, carried, work, q_a, q_b, n, margin, of_world)


@routine
def samples_in(waiting, i, n_blocks):
    """Which of 8 n_blocks samples, the first at a share of 1 / (8 n_blocks), are in an interval: the first, and the one after."""
    middle, half, n = waiting[i, 0], waiting[i, 1], WIDTH * n_blocks
    return int((middle - half) * n) + 1, int((middle + half) * n) + 1


@kernel
def touches_at(scene, carried, work, q_a, q_b, n, margin, of_world):
    """Whether the robot is not free at the first n configurations of eight, n > 0."""
    lane_rows = work[1]
    for lane in range(WIDTH):
        lane_rows[0, lane], lane_rows[1, lane] = lane_rows[0, min(lane, n - 1)], 0.0
    touches = outcome_at(scene, carried, work, q_a, q_b, 0.0, n > 0, margin, of_world)
    for lane in range(WIDTH):
        touches = touches or lane_rows[2, lane] == 0.0
    return touches
