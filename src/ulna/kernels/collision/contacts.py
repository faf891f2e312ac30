"""Computes contacts with the gradients of their distances, and finds the near pairs at one q.

A pair is a body of the robot, and another body or an object of the world. Objects are numbered after the n bodies: object w has
the number n + w. The search has these steps:

1. For each body of the robot, test the objects: the unindexed ones, and those within the distance in the BVH, from the nearest
   node on. Then test the robot's own pairs. Pairs whose bounding balls or boxes are too far apart are left out.
2. Compute the contact of each other pair, and keep it if it is near enough. For an object of many solids, each body keeps the
   nearest solid, and solids certainly farther away are not measured. If the caller gives ``excess`` (``find_near_pairs``), only
   the nearest pairs of all are kept, as many as the caller's rows can hold.
3. Sort the kept pairs, the nearest first.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.kernels.collision.bounding_planes import add_plane, beyond_planes, normal_of
from ulna.kernels.collision.bvh import (
    bounds_of,
    child_boxes,
    child_gap,
    gap_bound,
    gap_in_body_frame,
    push_children,
    row_of_one_object,
)
from ulna.kernels.collision.collision_layout import (
    DISTANCE,
    FIRST_BALL,
    NORMAL,
    PAIR_BODY,
    PAIR_OBJECT,
    PAIR_OTHER,
    WITNESS_A,
    WITNESS_B,
)
from ulna.kernels.collision.posed_pair import (
    BALLS,
    ball_distance,
    body_at,
    box_rows_gap,
    extra_margin,
    gap_is_searched,
    max_extra_margin,
    may_touch,
    rows_contact,
    rows_gap,
    solid_at,
)
from ulna.kernels.collision.scene import Nearness
from ulna.kernels.layout import COLUMN, JOINT, KIND, LARGEST, OBJECT, PARENT, PRISMATIC, RADIUS, RATIO, REACH
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.se3 import load_pose
from ulna.kernels.spatial.vectors import cross, dot, minus, origin, transform_inverse, z_axis

PAIRS_OF_BODY = 6  # with the world, that a servo keeps
MAX_LOOKS = 1024  # solids of the tree that a servo measures for one body; and the limit for pairs whose distance needs a search
MAX_SEARCHES = 128
SAME = 1e-9  # [m]: a servo measures no solid of a tree that is nearer than the kept ones by less than this


@kernel
def write_contact(scene, body_rows, i, j, scratch, out, row):
    """Write the contact of a pair, in plain numbers, to a row of out."""
    ours, n = body_at(scene, i, load_pose(body_rows, i)), scene.bodies.shape[0]
    if j < n:
        distance, p, q, normal = rows_contact(ours, body_at(scene, j, load_pose(body_rows, j)), scratch)
    else:
        distance, p, q, normal = rows_contact(ours, solid_at(scene, j - n, 0.0), scratch)
    out[row, DISTANCE] = distance
    out[row, WITNESS_A], out[row, WITNESS_A + 1], out[row, WITNESS_A + 2] = p
    out[row, WITNESS_B], out[row, WITNESS_B + 1], out[row, WITNESS_B + 2] = q
    out[row, NORMAL], out[row, NORMAL + 1], out[row, NORMAL + 2] = normal


@kernel
def write_gradient(scene, joint_rows, i, j, contacts, out, row):
    """Write the gradient of the distance of a pair to a row of out."""
    for k in range(out.shape[1]):
        out[row, k] = 0.0
    if i >= 0:
        contact, gradient = contacts[row], out[row]
        add_speeds(scene.joints, joint_rows, int(scene.bodies[i, JOINT]), contact, WITNESS_A, -1.0, gradient)
        if j < scene.bodies.shape[0]:
            add_speeds(scene.joints, joint_rows, int(scene.bodies[j, JOINT]), contact, WITNESS_B, 1.0, gradient)


@kernel
def add_speeds(joints, joint_rows, joint, contact, witness, sign, gradient):
    """Add the normal speeds of a witness point to a gradient, times a sign.

    Entry i is the speed along the normal as joint i moves at unit rate, for the joints that carry the body.
    """
    point = contact[witness], contact[witness + 1], contact[witness + 2]
    normal = contact[NORMAL], contact[NORMAL + 1], contact[NORMAL + 2]
    while joint >= 0:
        pose = load_pose(joint_rows, joint)
        z = z_axis(pose)
        if int(joints[joint, KIND]) != PRISMATIC:
            z = cross(z, minus(point, origin(pose)))
        gradient[int(joints[joint, COLUMN])] += sign * joints[joint, RATIO] * dot(normal, z)
        joint = int(joints[joint, PARENT])


@kernel
def find_near_pairs(scene, clearance, margins, within, near, excess):
    """Steps 1 and 2 of the search; the number of pairs, which exceeds the rows if room is missing.

    within: The maximum distance beyond the required one [m]. The required distance is the clearance for objects and 0 for links.
    excess: None; or, with shape (room + 1,), the search keeps only the nearest pairs. Then entry i is the margin of pair i: its
    distance beyond the required one, or a lower bound where the certificates compute only a bound. The last entry is the minimum
    over all pairs of their true distance beyond the required one.
    """
    objects, links, count = Nearness(clearance, margins, within), Nearness(0.0, margins, within), 0
    for k in range(scene.bodies.shape[0]):
        first, ours = count, body_at(scene, k, load_pose(near.body_rows, k))
        for w in range(scene.first, scene.end):
            count = add_solid(scene, ours, w, objects, near, excess, (first, count))
        if scene.root >= 0:
            count = add_indexed(scene, ours, objects, near, excess, count)
    for p in range(scene.pairs.shape[0]):
        i, j = scene.pairs[p, 0], scene.pairs[p, 1]
        if excess is not None:
            count = add_nearest_pair(scene, i, j, links, near, excess, count)
        else:
            ours, theirs = body_at(scene, i, load_pose(near.body_rows, i)), body_at(scene, j, load_pose(near.body_rows, j))
            if ball_distance(ours, theirs) <= within:
                count = add_pair(scene, i, j, -1, within, near, count)
    return count


@kernel
def add_indexed(scene, ours, nearness, near, excess, first):
    """Add a body and its near solids of the tree, the nearest nodes first; the new count.

    If ``near.unseen`` has an entry, about MAX_LOOKS solids are measured, and a lower bound for all others is written there.
    """
    k, (clearance, margins, within) = ours.row, nearness
    bounds, n, count, top = bounds_of(scene.bodies, k, ours.pose), scene.bodies.shape[0], first, 1
    n_measured, margin = 0, clearance + max_extra_margin(margins, 2)
    near.stack[0], near.heights[0] = scene.root, -np.inf
    while top > 0:
        top -= 1
        node, reach = near.stack[top], margin + within
        if excess is not None:
            reach = margin + max(slot_of_pair(k, n, n, within, near, excess, count)[1], excess[-1]) - SAME
        elif node >= 0 and near.last_rows.shape[0] > 0:
            reach = reach_in_node(scene, k, node, near, (first, count), reach)
        if not near.heights[top] <= reach:
            continue
        if n_measured > MAX_LOOKS and near.unseen.shape[0] > 0:
            near.unseen[0] = min(near.unseen[0], near.heights[top] - margin)
        elif node >= 0:
            height = children_from(scene, ours, node, bounds, near)
            top = push_children(scene, node, height, reach, near.stack, near.heights, top)
        else:
            theirs = solid_at(scene, -1 - node, 0.0)
            n_measured += MAX_LOOKS // MAX_SEARCHES if gap_is_searched(ours, theirs) else 1
            count = add_solid(scene, ours, -1 - node, nearness, near, excess, (first, count))
    return count


@kernel
def children_from(scene, ours, node, bounds, near):
    """A lower bound of the distance of each child of a node [m].

    bounds: The body's AABB in the base frame.

    In a scene of boxes alone there is no cloud. With a cloud, the bound in the body's frame excludes many of its points.
    """
    gap = gap_bound(child_gap(scene, node, bounds))
    if scene.vertices is None:
        return gap
    return gap + maximum(bound_in_body_frame(scene, ours, node, near) - gap, 0.0)  # NaN if the gap is NaN


@kernel
def bound_in_body_frame(scene, ours, node, near):
    """A lower bound of the distance of each child of a node, as seen in the body's frame [m]."""
    k, a, (center, half) = ours.row, ours.pose, child_boxes(scene, node)
    x = transform_inverse(a, center)
    return maximum(gap_bound(gap_in_body_frame(scene.bodies, k, a, x, half)), beyond_planes(near.planes, k, a, x, half))


@kernel
def reach_in_node(scene, k, node, near, row_range, reach):
    """The distance below which a node's solid is kept [m]: one of a cloud, all of separate boxes."""
    if scene.vertices is None:
        return reach
    return reach_of_one_object(scene, k, node, near, row_range, reach)


@routine
def reach_of_one_object(scene, k, node, near, row_range, reach):
    """``reach_in_node`` for shapes: if one object owns the whole node, the distance of its kept solid."""
    (first, count), row = row_range, row_of_one_object(scene.nodes, scene.objects, node)
    if row >= 0 and may_touch(scene, k, row):
        return -np.inf
    last = -1 if row < 0 else row_of_object(near, int(scene.objects[row, OBJECT]), first, count)
    same = SAME if near.unseen.shape[0] > 0 else 0.0
    return reach if last < 0 else min(reach, near.contact_rows[last, DISTANCE] - same)


@kernel
def row_of_object(near, number, first, count):
    """The row of an object's kept solid, from a first row on; -1 if there is none."""
    last = near.last_rows[number]
    found = first <= last < min(count, near.pair_rows.shape[0]) and near.pair_rows[last, PAIR_OBJECT] == number
    return last if found else -1


@kernel
def add_solid(scene, ours, w, nearness, near, excess, row_range):
    """Add a body and solid w of the world if they are near; the new count.

    row_range: The first row of that body, and the count.
    """
    k, (_, count) = ours.row, row_range
    if excess is not None:
        return add_nearest_pair(scene, k, scene.bodies.shape[0] + w, nearness, near, excess, count)
    theirs, within = solid_at(scene, w, 0.0), nearness.within
    bound = distance_bound(ours, theirs, within)
    if not bound <= within or may_touch(scene, k, theirs.row):
        return count
    return add_nearest_solid(scene, k, (w, int(scene.objects[theirs.row, OBJECT]), bound), within, near, row_range)


@routine
def add_nearest_pair(scene, i, j, nearness, near, excess, count):
    """Write a near pair to a free row, or over a farther pair; the new count."""
    clearance, margins, within = nearness
    room, n, ours, number = near.pair_rows.shape[0], scene.bodies.shape[0], body_at(scene, i, load_pose(near.body_rows, i)), -1
    if j < n:
        theirs = body_at(scene, j, load_pose(near.body_rows, j))
    else:
        theirs = solid_at(scene, j - n, 0.0)
        if may_touch(scene, i, theirs.row):
            return count
        number = int(scene.objects[theirs.row, OBJECT])
        clearance = clearance + extra_margin(scene, margins, theirs.row)
    slot, farthest = slot_of_pair(i, j, n, within, near, excess, count)
    limit = max(farthest, excess[room])
    reach = clearance + limit
    if distance_bound(ours, theirs, reach) >= reach:
        return count
    is_ball, gap = j >= n + FIRST_BALL, reach
    if is_ball and ball_beyond_planes(ours, theirs, near.planes) >= reach:
        return count
    if not (gap_is_searched(ours, theirs) and (is_ball or reach <= 0.0)):  # a search finds neither a depth nor a plane
        gap = rows_gap(ours, theirs, reach, 0.0)
        if gap >= reach:
            return count
    write_contact(scene, near.body_rows, i, j, near.scratch, near.contact_rows, room)
    if is_ball:
        add_plane(ours.vertices, theirs.vertices, ours, theirs, near.planes, normal_of(near.contact_rows, room))
    distance = near.contact_rows[room, DISTANCE]
    excess[room] = min(excess[room], distance - clearance)
    if distance <= 0.0 or gap_is_searched(ours, theirs):
        gap = distance
    of_pair = min(gap, distance) - clearance
    if distance - clearance >= within or of_pair >= farthest:
        return count
    write_pair(i, j, number, near, slot)
    copy_row(near.contact_rows, room, near.contact_rows, slot)
    excess[slot] = of_pair
    return max(count, slot + 1)


@kernel
def ball_beyond_planes(ours, theirs, planes):
    """Lower bound on the distance of another body's bounding ball from the planes of our body [m]."""
    x = transform_inverse(ours.pose, origin(theirs.pose))
    return beyond_planes(planes, ours.row, ours.pose, x, (0.0, 0.0, 0.0)) - BALLS * theirs.table[theirs.row, REACH]


@kernel
def slot_of_pair(i, j, n, within, near, excess, count):
    """The row for a near pair of body i, and the limit that its excess must stay below [m].

    The row is a free one, or that of the farthest pair. Once body i has PAIRS_OF_BODY pairs with the world, it is the farthest of
    these. So a cloud beside one body leaves room for the pairs of others.
    """
    room, last, last_own, n_own = near.pair_rows.shape[0], 0, 0, 0
    for c in range(count):
        if excess[c] > excess[last]:
            last = c
        if j >= n and near.pair_rows[c, PAIR_BODY] == i and near.pair_rows[c, PAIR_OTHER] >= n:
            last_own = c if n_own == 0 or excess[c] > excess[last_own] else last_own
            n_own += 1
    if n_own >= PAIRS_OF_BODY:
        return last_own, excess[last_own]
    if count < room:
        return count, within
    return last, excess[last] if room > 0 else -np.inf


@kernel
def distance_bound(ours, theirs, reach):
    """A lower bound of the distance of two bodies [m], from bounding balls, and within reach from boxes."""
    bodies, i, others, j = ours.table, ours.row, theirs.table, theirs.row
    bound = ball_distance(ours, theirs)
    if bound > reach or not others[j, REACH] <= LARGEST:
        return bound
    gap = box_rows_gap(ours, theirs, 0.0)
    touching = (BALLS - 1.0) * (bodies[i, REACH] + others[j, REACH])  # bodies within the contact tolerance have the distance zero
    return max(bound, gap - bodies[i, RADIUS] - others[j, RADIUS] - touching)


@routine
def add_nearest_solid(scene, i, solid, within, near, row_range):
    """Add body i and a solid unless a nearer solid of the same object is kept; the new count.

    solid: Its number, its object's number, and a lower bound of its distance from body i [m]. row_range: As for ``add_solid``.
    """
    (w, number, bound), (first, count) = solid, row_range
    j = scene.bodies.shape[0] + w
    if near.last_rows.shape[0] == 0:
        return add_pair(scene, i, j, number, within, near, count)
    last, room = row_of_object(near, number, first, count), near.pair_rows.shape[0]
    if last < 0:
        near.last_rows[number] = count
        return add_pair(scene, i, j, number, within, near, count)
    distance = near.contact_rows[last, DISTANCE]
    if bound < distance and count < room:
        added = add_pair(scene, i, j, number, distance, near, count)
        if added > count and near.contact_rows[count, DISTANCE] < distance:
            copy_row(near.contact_rows, count, near.contact_rows, last)
            copy_row(near.pair_rows, count, near.pair_rows, last)
    elif bound < distance:
        return count + 1
    return count


@routine
def add_pair(scene, i, j, number, within, near, count):
    """Append the contact of a pair if it is at most ``within`` [m] apart; the new count.

    number: The object's number, or -1. Without room the pair is only counted.
    """
    if count >= near.pair_rows.shape[0]:
        return count + 1
    write_contact(scene, near.body_rows, i, j, near.scratch, near.contact_rows, count)
    if j >= scene.bodies.shape[0] + FIRST_BALL:
        ours, ball = body_at(scene, i, load_pose(near.body_rows, i)), solid_at(scene, j - scene.bodies.shape[0], 0.0)
        add_plane(ours.vertices, ball.vertices, ours, ball, near.planes, normal_of(near.contact_rows, count))
    if not near.contact_rows[count, DISTANCE] <= within:
        return count
    write_pair(i, j, number, near, count)
    return count + 1


@kernel
def write_pair(i, j, number, near, row):
    """Write a pair to a row: the body, the other one, the number of the object."""
    near.pair_rows[row, PAIR_BODY], near.pair_rows[row, PAIR_OTHER], near.pair_rows[row, PAIR_OBJECT] = i, j, number


@kernel
def copy_row(from_rows, i, to_rows, j):
    """Copy row i of an array to row j of another."""
    for k in range(from_rows.shape[1]):
        to_rows[j, k] = from_rows[i, k]


@routine
def order_of_rows(contact_rows, n, order):
    """Write the order of rows 0 to n - 1 by distance, and by row number for equal distances.

    Source: Shell, A high-speed sorting procedure (Communications of the ACM, 1959), with Knuth's gaps.
    """
    for i in range(n):
        order[i] = i
    gap = 1
    while gap < n // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(gap, n):
            row, k = order[i], i
            distance = contact_rows[row, DISTANCE]
            while k >= gap:
                other = order[k - gap]
                ahead = contact_rows[other, DISTANCE]
                if ahead < distance or (ahead == distance and other < row):
                    break
                order[k] = other
                k -= gap
            order[k] = row
        gap //= 3
