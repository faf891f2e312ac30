"""Finds the pairs that are at most a given distance apart at one q: robot with itself, robot with world.

1. For each body of the robot, the objects: the unindexed ones, and those that the BVH finds within the distance; then the robot's
   own pairs. Of these, pairs whose bounding balls are too far apart are left out.
2. The contact of each of the others is computed, and kept if it is near enough. Of an object of many solids each body keeps the
   nearest one: a solid whose ball is farther away than that is not measured.
3. What is kept is put in order, the nearest first.
"""

from ulna.engine.decorators import kernel, routine
from ulna.kernels.collision.bvh import bounds_within, rows_within
from ulna.kernels.collision.collision_layout import DISTANCE, PAIR_BODY, PAIR_OBJECT, PAIR_OTHER
from ulna.kernels.collision.contacts import write_contact
from ulna.kernels.collision.posed_pair import ball_distance, may_touch, solid_at
from ulna.kernels.layout import OBJECT
from ulna.kernels.spatial.se3 import load_pose


@kernel
def find_near_pairs(scene, body_rows, within, work, contact_rows, pair_rows):
    """Steps 1 and 2; how many pairs there are, or a larger number than the rows hold where there is no room for all.

    work: the stack of the BVH, what it finds, the scratch of EPA, and the last row of each object, shape (n_objects,), with any
    values; without any, all solids of an object are kept.

    Writes contacts to contact_rows, shape (room, CONTACT_WIDTH), and bodies to pair_rows, shape (room, PAIR_WIDTH).
    """
    stack, found, scratch, last_rows = work
    bodies, n, count = scene.bodies, scene.bodies.shape[0], 0
    for k in range(n):
        first, a = count, load_pose(body_rows, k)
        for w in range(scene.first, scene.end):
            least, row = object_bound(scene, k, a, w)
            if least <= within and not may_touch(scene, k, row):
                count = add_object(
                    scene, body_rows, k, w, row, least, within, first, count, scratch, last_rows, contact_rows, pair_rows
                )
        if scene.root >= 0:
            bounds, top = bounds_within(bodies, k, a, within), 1
            stack[0] = scene.root
            while top > 0:
                n_found, top = rows_within(scene.nodes, bounds, stack, top, found)
                for i in range(n_found):
                    w = found[i]
                    least, row = object_bound(scene, k, a, w)
                    if least <= within and not may_touch(scene, k, row):
                        count = add_object(
                            scene, body_rows, k, w, row, least, within, first, count, scratch, last_rows, contact_rows, pair_rows
                        )
    for p in range(scene.pairs.shape[0]):
        i, j = scene.pairs[p, 0], scene.pairs[p, 1]
        if ball_distance(bodies, i, load_pose(body_rows, i), bodies, j, load_pose(body_rows, j)) <= within:
            count = add_pair(scene, body_rows, i, j, -1, within, count, scratch, contact_rows, pair_rows)
    return count


@kernel
def object_bound(scene, k, a, w):
    """A lower bound of the distance of body k, at pose a, and solid w of the world; and the solid's row."""
    row, b = solid_at(scene, w, 0.0)
    return ball_distance(scene.bodies, k, a, scene.objects, row, b), row


@routine
def add_object(scene, body_rows, k, w, row, least, within, first, count, scratch, last_rows, contact_rows, pair_rows):
    """Add body k and solid w of the world, ``least`` [m] apart at least; the new count. The rows of body k begin at ``first``."""
    number = int(scene.objects[row, OBJECT])
    if last_rows.shape[0] == 0:
        return add_pair(scene, body_rows, k, scene.bodies.shape[0] + w, number, within, count, scratch, contact_rows, pair_rows)
    last = last_rows[number]
    is_known = first <= last < min(count, pair_rows.shape[0]) and pair_rows[last, PAIR_OBJECT] == number
    if not is_known:
        last_rows[number] = count
        return add_pair(scene, body_rows, k, scene.bodies.shape[0] + w, number, within, count, scratch, contact_rows, pair_rows)
    distance = contact_rows[last, DISTANCE]
    if least < distance and count < pair_rows.shape[0]:
        added = add_pair(
            scene, body_rows, k, scene.bodies.shape[0] + w, number, distance, count, scratch, contact_rows, pair_rows
        )
        if added > count and contact_rows[count, DISTANCE] < distance:
            copy_row(contact_rows, count, contact_rows, last)
            copy_row(pair_rows, count, pair_rows, last)
    elif least < distance:
        return count + 1
    return count


@routine
def add_pair(scene, body_rows, i, j, number, within, count, scratch, contact_rows, pair_rows):
    """Write the contact of a pair behind ``count`` rows; the new count: one more if it is at most ``within`` [m] apart.

    number: that of the object, or -1. Where there is no room it is counted only.
    """
    if count >= pair_rows.shape[0]:
        return count + 1
    write_contact(scene, body_rows, i, j, scratch, contact_rows, count)
    if not contact_rows[count, DISTANCE] <= within:
        return count
    pair_rows[count, PAIR_BODY], pair_rows[count, PAIR_OTHER], pair_rows[count, PAIR_OBJECT] = i, j, number
    return count + 1


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
