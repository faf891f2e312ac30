"""Computes contacts of pairs with the gradients of their distances, and finds the pairs that are near each other at one q.

A pair is a body of the robot and another, or an object of the world, numbered from the last body on. Those near each other:

1. For each body of the robot, the objects: the unindexed ones, and those that the BVH finds within the distance, from the
   nearest node on; then the robot's own pairs. Of these, pairs whose bounding balls or boxes are too far apart are left out.
2. The contact of each of the others is computed, and kept if it is near enough. Of an object of many solids each body keeps the
   nearest one, and a solid that is known to be farther away than that is not measured; or, of all pairs, as many as there is
   room for are kept, the nearest.
3. What is kept is put in order, the nearest first.
"""

import numpy as np

from ulna.engine.decorators import kernel, routine
from ulna.kernels.collision.bounding_planes import add_plane, beyond_planes, normal_of
from ulna.kernels.collision.bvh import bounds_of, child_boxes, child_gap, gap_bound, push_children, row_of_one_object, turned_gap
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
    gap_is_searched,
    may_touch,
    rows_contact,
    rows_gap,
    solid_at,
    wider_by,
    widest,
)
from ulna.kernels.collision.scene import Nearness
from ulna.kernels.layout import COLUMN, JOINT, KIND, LARGEST, OBJECT, PARENT, PRISMATIC, RADIUS, RATIO, REACH
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.se3 import load_pose
from ulna.kernels.spatial.vectors import cross, dot, minus, origin, transform_inverse, z_axis

PAIRS_OF_BODY = 6  # with the world, that a servo keeps
MAX_LOOKS = 1024  # solids of the tree that a servo measures from one body; of those whose distance is searched
MAX_SEARCHES = 128
SAME = 1e-9  # [m]: of the solids of a tree that are nearer by less than those kept, a servo measures none


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
    """Add to a gradient, for each entry of q, sign times the speed along the normal of a witness point moved by a joint."""
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
def find_near_pairs(scene, clearance, apart, within, near, excess):
    """Steps 1 and 2 for the bodies in ``near``; how many pairs, or a larger number than the rows hold where there is no room.

    within: how much farther apart they are at most [m] than they have to be: objects by the clearance, links not at all. excess:
    None; or shape (room + 1,), and then only the nearest pairs are kept: by how much each is farther apart than it has to be, by
    the lower bound of its distance that certificates compute, where these need it, and last the least of all pairs, by their
    distance.
    """
    objects, links, count = Nearness(clearance, apart, within), Nearness(0.0, apart, within), 0
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
    """Add a body and the solids of the tree that are near it, the nearest nodes first; the new count.

    Where ``near.unseen`` has a place, about MAX_LOOKS of them are measured, and what all others are at least is written there.
    """
    k, (clearance, apart, within) = ours.row, nearness
    bounds, n, count, top = bounds_of(scene.bodies, k, ours.pose), scene.bodies.shape[0], first, 1
    looks, more = 0, clearance + widest(apart, 2)
    near.stack[0], near.heights[0] = scene.root, -np.inf
    while top > 0:
        top -= 1
        node, reach = near.stack[top], more + within
        if excess is not None:
            reach = more + max(slot_of_pair(k, n, n, within, near, excess, count)[1], excess[-1]) - SAME
        elif node >= 0 and near.last_rows.shape[0] > 0:
            reach = reach_in_node(scene, k, node, near, (first, count), reach)
        if not near.heights[top] <= reach:
            continue
        if looks > MAX_LOOKS and near.unseen.shape[0] > 0:
            near.unseen[0] = min(near.unseen[0], near.heights[top] - more)
        elif node >= 0:
            height = children_from(scene, ours, node, bounds, near)
            top = push_children(scene.nodes, node, height, reach, near.stack, near.heights, top)
        else:
            theirs = solid_at(scene, -1 - node, 0.0)
            looks += MAX_LOOKS // MAX_SEARCHES if gap_is_searched(ours, theirs) else 1
            count = add_solid(scene, ours, -1 - node, nearness, near, excess, (first, count))
    return count


@kernel
def children_from(scene, ours, node, bounds, near):
    """A lower bound of the distance of each child of a node [m]. bounds: of the body, in the base.

    Where all shapes are boxes there is no cloud, of which the bound in the body's frame leaves many points out.
    """
    gap = gap_bound(child_gap(scene.nodes, node, bounds))
    if scene.vertices is None:
        return gap
    return gap + maximum(turned_bound(scene, ours, node, near) - gap, 0.0)  # NaN if the gap is NaN


@kernel
def turned_bound(scene, ours, node, near):
    """A lower bound of the distance of each child of a node, as the body's frame sees it [m]."""
    k, a, (center, half) = ours.row, ours.pose, child_boxes(scene.nodes, node)
    x = transform_inverse(a, center)
    return maximum(gap_bound(turned_gap(scene.bodies, k, a, x, half)), beyond_planes(near.planes, k, a, x, half))


@kernel
def reach_in_node(scene, k, node, near, kept, reach):
    """The distance below which a solid of a node is kept [m]: of a cloud one is. Boxes are looked at one by one."""
    if scene.vertices is None:
        return reach
    return reach_of_one_object(scene, k, node, near, kept, reach)


@routine
def reach_of_one_object(scene, k, node, near, kept, reach):
    """``reach_in_node``: where all solids below it are of one object, the distance of the one of it that is kept."""
    (first, count), row = kept, row_of_one_object(scene.nodes, scene.objects, node)
    if row >= 0 and may_touch(scene, k, row):
        return -np.inf
    last = -1 if row < 0 else kept_row(near, int(scene.objects[row, OBJECT]), first, count)
    same = SAME if near.unseen.shape[0] > 0 else 0.0
    return reach if last < 0 else min(reach, near.contact_rows[last, DISTANCE] - same)


@kernel
def kept_row(near, number, first, count):
    """The row in which the nearest solid of an object is kept, from a first row on; -1 if none is."""
    last = near.last_rows[number]
    found = first <= last < min(count, near.pair_rows.shape[0]) and near.pair_rows[last, PAIR_OBJECT] == number
    return last if found else -1


@kernel
def add_solid(scene, ours, w, nearness, near, excess, kept):
    """Add a body and solid w of the world if they are near; the new count.

    kept: the first row of that body, and the count.
    """
    k, (_, count) = ours.row, kept
    if excess is not None:
        return add_nearest_pair(scene, k, scene.bodies.shape[0] + w, nearness, near, excess, count)
    theirs, within = solid_at(scene, w, 0.0), nearness.within
    least = least_distance(ours, theirs, within)
    if not least <= within or may_touch(scene, k, theirs.row):
        return count
    return add_nearest_solid(scene, k, (w, int(scene.objects[theirs.row, OBJECT]), least), within, near, kept)


@routine
def add_nearest_pair(scene, i, j, nearness, near, excess, count):
    """Write a pair that is near, where there is room or in place of a farther one; the new count."""
    clearance, apart, within = nearness
    room, n, ours, number = near.pair_rows.shape[0], scene.bodies.shape[0], body_at(scene, i, load_pose(near.body_rows, i)), -1
    if j < n:
        theirs = body_at(scene, j, load_pose(near.body_rows, j))
    else:
        theirs = solid_at(scene, j - n, 0.0)
        if may_touch(scene, i, theirs.row):
            return count
        number = int(scene.objects[theirs.row, OBJECT])
        clearance = clearance + wider_by(scene, apart, theirs.row)
    slot, farthest = slot_of_pair(i, j, n, within, near, excess, count)
    limit = max(farthest, excess[room])
    reach = clearance + limit
    if least_distance(ours, theirs, reach) >= reach:
        return count
    is_ball, gap = j >= n + FIRST_BALL, reach
    if is_ball and ball_beyond_planes(ours, theirs, near.planes) >= reach:
        return count
    if not (gap_is_searched(ours, theirs) and (is_ball or reach <= 0.0)):  # a search knows of no depth, and finds no plane
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
    """How far the bounding ball of another body is beyond the planes of ours at least [m]."""
    x = transform_inverse(ours.pose, origin(theirs.pose))
    return beyond_planes(planes, ours.row, ours.pose, x, (0.0, 0.0, 0.0)) - BALLS * theirs.table[theirs.row, REACH]


@kernel
def slot_of_pair(i, j, n, within, near, excess, count):
    """Where a pair of body i goes that is near enough, and how much farther apart than it has to be it may be for that [m].

    A free row; or that of the farthest pair of all, or of body i and the world, where it has PAIRS_OF_BODY with it: a cloud
    beside one body leaves room for the pairs of others.
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
def least_distance(ours, theirs, reach):
    """A lower bound of the distance of two bodies [m]: by their bounding balls, and within reach by boxes round them."""
    bodies, i, others, j = ours.table, ours.row, theirs.table, theirs.row
    least = ball_distance(ours, theirs)
    if least > reach or not others[j, REACH] <= LARGEST:
        return least
    gap = box_rows_gap(ours, theirs, 0.0)
    touching = (BALLS - 1.0) * (bodies[i, REACH] + others[j, REACH])  # bodies within the contact tolerance are zero apart
    return max(least, gap - bodies[i, RADIUS] - others[j, RADIUS] - touching)


@routine
def add_nearest_solid(scene, i, solid, within, near, kept):
    """Add body i and a solid unless a nearer solid of the same object is kept; the new count.

    solid: its number, that of its object, and how far from body i it is at least [m]; kept: as for ``add_solid``.
    """
    (w, number, least), (first, count) = solid, kept
    j = scene.bodies.shape[0] + w
    if near.last_rows.shape[0] == 0:
        return add_pair(scene, i, j, number, within, near, count)
    last, room = kept_row(near, number, first, count), near.pair_rows.shape[0]
    if last < 0:
        near.last_rows[number] = count
        return add_pair(scene, i, j, number, within, near, count)
    distance = near.contact_rows[last, DISTANCE]
    if least < distance and count < room:
        added = add_pair(scene, i, j, number, distance, near, count)
        if added > count and near.contact_rows[count, DISTANCE] < distance:
            copy_row(near.contact_rows, count, near.contact_rows, last)
            copy_row(near.pair_rows, count, near.pair_rows, last)
    elif least < distance:
        return count + 1
    return count


@routine
def add_pair(scene, i, j, number, within, near, count):
    """Write the contact of a pair behind ``count`` rows; the new count: one more if it is at most ``within`` [m] apart.

    number: that of the object, or -1. Where there is no room it is counted only.
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
    """Write to order the rows 0 to n - 1, that of the least distance first, and of equal ones the lower row.

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
