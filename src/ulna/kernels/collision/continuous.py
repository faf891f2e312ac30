"""Certifies that the robot is free on the straight line between two configurations. Used by ``drivers.continuous``.

Conservative advancement (Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996; Zhang, Lee and Kim, Interactive
continuous collision detection for non-convex polyhedra, The Visual Computer 2006), eight steps at a time:

1. On q(t) = q_a + t (q_b - q_a) no point of a body moves faster than the sum, over the joints that carry it, of the joint's
   rate times the greatest distance that the point can have from the joint's axis: the lengths of the links between, added up.
   The distance of two bodies shrinks no faster than the sum over the joints that carry only one of them.
2. If at the middle of an interval of t a pair is farther apart than its speed times half the interval's length, it is free in
   all of the interval. Eight consecutive intervals are computed together, a lane each. The distance is replaced by a lower bound,
   the gap of the two projections on one direction (``posed_pair.rows_gap``), so that an inexact search cannot certify too much.
3. Advance over the leading intervals in which all pairs are free. If all eight are free, the next eight are eight times as long.
   If not, split the first that is not free into eight. If it is so short that nothing moves by the resolution, it is a contact.

A bound on the rounding errors is added to the motion of a pair: for each body a fraction of all lengths between it and the base,
and the rounding of each angle of q(t) times the lever arm of its joint.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, lane_count, lane_of, splat, sqrt, where
from ulna.engine.width import WIDTH
from ulna.kernels.collision.bvh import bounds_of, objects_within
from ulna.kernels.collision.posed_pair import ball_distance, rows_gap
from ulna.kernels.layout import COLUMN, HALF_SPACE, JOINT, KIND, OFFSET, PARENT, PRISMATIC, RATIO, REACH, SHAPE
from ulna.kernels.spatial.se3 import constant_pose, load_pose

ROUNDING = 1e-12  # of the lengths between a body and the base: more than poses and gaps lose to it
ANGLE = 2e-15  # of an angle: more than the line in q, a mimic's ratio and the reduction of many turns lose to rounding
INSTANT = 1e-15  # of t: neighbouring intervals may leave out so much between them
CROWD = 256  # objects near a body in eight intervals: with more than these the intervals are split first


@kernel
def write_speeds(scene, q_a, q_b, speeds):
    """Write to speeds, shape (n_bodies, n_joints + 2), how fast each joint can move a point of each body; then the sum.

    And last how far rounding may put a point of it [m].
    """
    joints, bodies, n = scene.joints, scene.bodies, scene.joints.shape[0]
    for k in range(bodies.shape[0]):
        for i in range(n + 2):
            speeds[k, i] = 0.0
        length, i = bodies[k, REACH] + offset_length(bodies, k), int(bodies[k, JOINT])
        while i >= 0:
            column, ratio, offset = int(joints[i, COLUMN]), joints[i, RATIO], joints[i, OFFSET]
            rate, largest = abs(ratio * (q_b[column] - q_a[column])), max(abs(q_a[column]), abs(q_b[column]))
            if int(joints[i, KIND]) == PRISMATIC:
                length += abs(ratio) * largest + abs(offset)
            else:
                rate *= length
                speeds[k, n + 1] += ANGLE * (abs(ratio) * largest + abs(offset)) * length
            speeds[k, i] = rate
            speeds[k, n] += rate
            length += offset_length(joints, i)
            i = int(joints[i, PARENT])
        speeds[k, n + 1] += ROUNDING * length


@kernel
def offset_length(table, i):
    """The distance of the frame of a row from its parent frame [m]."""
    return sqrt(table[i, 3] * table[i, 3] + table[i, 7] * table[i, 7] + table[i, 11] * table[i, 11])


@kernel
def pair_speed(speeds, a, b):
    """The greatest speed at which the distance of two bodies of the robot can shrink: joints that move both do not count."""
    total = 0.0
    for i in range(speeds.shape[1] - 2):
        if speeds[a, i] == 0.0 or speeds[b, i] == 0.0:
            total += speeds[a, i] + speeds[b, i]
    return total


@kernel
def world_rounding(scene):
    """A bound on the rounding error of any object's points [m], from the unindexed objects and the AABBs at the BVH's root."""
    largest, objects, nodes = 0.0, scene.objects, scene.nodes
    for w in range(scene.n_unindexed):
        length = offset_length(objects, w)
        largest = max(largest, length if int(objects[w, SHAPE]) == HALF_SPACE else length + objects[w, REACH])
    if objects.shape[0] > scene.n_unindexed:
        for child in range(WIDTH):
            if nodes[0, child] <= nodes[3, child]:  # else there is none
                for axis in range(3):
                    largest = max(largest, 4.0 * max(abs(nodes[axis, child]), abs(nodes[3 + axis, child])))
    return ROUNDING * largest


@kernel
def still_clear(clear, bodies, vertices, k, a, others, points, j, b, way, rounding):
    """``clear`` (1.0 or 0.0 per lane), and 0.0 where two bodies may be nearer than their motion and its rounding [m]."""
    reach = way * (1.0 + ROUNDING) + rounding
    if not any_lane((ball_distance(bodies, k, a, others, j, b) <= reach) & (clear > 0.0)):
        return clear
    return where(rows_gap(bodies, vertices, k, a, others, points, j, b, reach, rounding) > reach, clear, 0.0)


@kernel
def clear_intervals(scene, body_rows, speeds, half, of_world, finest, like, stack, found):
    """1.0 in the lanes in whose interval, of half length ``half``, all pairs are free; 0.0 in the others."""
    bodies, vertices, objects, n_unindexed = scene.bodies, scene.vertices, scene.objects, scene.n_unindexed
    clear, n_joints, n_indexed = splat(1.0, like), speeds.shape[1] - 2, objects.shape[0] - n_unindexed
    for p in range(scene.pairs.shape[0]):
        i, j = scene.pairs[p, 0], scene.pairs[p, 1]
        way, rounding = pair_speed(speeds, i, j) * half, speeds[i, n_joints + 1] + speeds[j, n_joints + 1]
        a, b = load_pose(body_rows, i), load_pose(body_rows, j)
        clear = still_clear(clear, bodies, vertices, i, a, bodies, vertices, j, b, way, rounding)
    for k in range(bodies.shape[0]):
        way, rounding = speeds[k, n_joints] * half, speeds[k, n_joints + 1] + of_world
        a, n_found = load_pose(body_rows, k), 0
        if n_indexed > 0:
            reach = way * (1.0 + ROUNDING) + rounding
            n_found = objects_within(scene.nodes, n_indexed, bounds_of_all(bodies, k, a, reach), stack, found)
            if n_found > CROWD and not finest:
                return splat(0.0, like)
        for i in range(n_unindexed + n_found):
            w = i if i < n_unindexed else n_unindexed + found[i - n_unindexed]
            b = constant_pose(objects, w, like)
            clear = still_clear(clear, bodies, vertices, k, a, objects, scene.points, w, b, way, rounding)
        if not any_lane(clear > 0.0):
            return clear
    return clear


@kernel
def bounds_of_all(bodies, k, a, reach):
    """One AABB, in plain numbers, around a body in all lanes, enlarged by a reach [m]."""
    (x, y, z), (u, v, w) = bounds_of(bodies, k, a)
    low, high = (span_of(x)[0], span_of(y)[0], span_of(z)[0]), (span_of(u)[1], span_of(v)[1], span_of(w)[1])
    return (low[0] - reach, low[1] - reach, low[2] - reach), (high[0] + reach, high[1] + reach, high[2] + reach)


@kernel
def span_of(x):
    """The least and the greatest of the lanes, plain numbers."""
    least = greatest = lane_of(x, 0)
    for lane in range(1, lane_count(x)):
        least, greatest = min(least, lane_of(x, lane)), max(greatest, lane_of(x, lane))
    return least, greatest


@kernel
def fastest_of(speeds, pairs):
    """The greatest speed at which the distance of any pair can shrink."""
    fastest = 0.0
    for k in range(speeds.shape[0]):
        fastest = max(fastest, speeds[k, speeds.shape[1] - 2])
    for p in range(pairs.shape[0]):
        fastest = max(fastest, pair_speed(speeds, pairs[p, 0], pairs[p, 1]))
    return fastest
