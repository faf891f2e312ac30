"""Computes poses of the robot's bodies at q, and distance or overlap of pairs of rows.

Each table comes with its vertices. If either is None, all shapes are boxes. A scene of boxes, the most frequent, thus compiles
without GJK and EPA, in a fraction of the time.
"""

from ulna.engine.decorators import kernel, shared_routine
from ulna.engine.lanes import WIDTH, load, splat, sqrt
from ulna.kernels.chain.poses import frame_pose, tree_poses
from ulna.kernels.collision.collision_layout import BALL_ROW, CHILD, FIRST_BALL, NODE_ROWS, PAIR_BODY, PAIR_OBJECT
from ulna.kernels.distance.box_distance import box_pair
from ulna.kernels.distance.box_sat import boxes_overlap, certain_gap
from ulna.kernels.distance.pairs import body_of, is_searched, pair_distance, pair_gap, pair_overlap
from ulna.kernels.layout import BOX, CONTACT, HALF_EXTENTS, OBJECT, REACH, SHAPE, TOUCH_SET
from ulna.kernels.spatial.se3 import constant_pose, store_pose
from ulna.kernels.spatial.vectors import dot, minus, origin

BALLS = 1.0 + 4.0 * CONTACT  # factor on the bounding balls, so that bodies within the contact tolerance have balls that overlap


@kernel
def place_bodies(joints, bodies, q_rows, joint_rows, body_rows):
    """Write the pose of every body of the robot to body_rows."""
    tree_poses(joints, q_rows, joint_rows)
    for k in range(bodies.shape[0]):
        store_pose(body_rows, k, frame_pose(bodies, k, joint_rows, load(q_rows, 0)))


@kernel
def rows_overlap(bodies, vertices, i, a, others, points, j, b, wanted):
    """True where body i of one table, at pose a, and body j of another, at pose b, share a point.

    wanted: 1.0 where that is to be found; elsewhere, where it is 0.0, the result may be either. Boxes, the most frequent, are
    tested inline; other shapes by a call, which keeps the loops over boxes small.
    """
    if vertices is None or points is None:
        return boxes_overlap(a, half_extents(bodies, i, a[0]), b, half_extents(others, j, a[0]))
    if int(bodies[i, SHAPE]) == BOX and int(others[j, SHAPE]) == BOX:
        return boxes_overlap(a, half_extents(bodies, i, a[0]), b, half_extents(others, j, a[0]))
    return convex_overlap(bodies, vertices, i, a, others, points, j, b, wanted)


@shared_routine
def convex_overlap(bodies, vertices, i, a, others, points, j, b, wanted):
    """``rows_overlap`` for convex shapes of any kind."""
    return pair_overlap(body_of(bodies, vertices, i, a), body_of(others, points, j, b), wanted)


@kernel
def rows_contact(bodies, vertices, i, a, others, points, j, b, scratch):
    """The contact (``pairs``) of body i of one table, at pose a, and body j of another, at pose b."""
    if vertices is None or points is None:
        return box_pair(a, half_extents(bodies, i, a[0]), b, half_extents(others, j, a[0]))
    return pair_distance(body_of(bodies, vertices, i, a), body_of(others, points, j, b), scratch)


@kernel
def rows_gap(bodies, vertices, i, a, others, points, j, b, reach, rounding):
    """A lower bound of the distance of two bodies [m], up to a rounding [m]; above reach [m] it may be any larger number."""
    if vertices is None or points is None:
        return certain_gap(a, half_extents(bodies, i, a[0]), b, half_extents(others, j, a[0]), rounding)
    if int(bodies[i, SHAPE]) == BOX and int(others[j, SHAPE]) == BOX:
        return certain_gap(a, half_extents(bodies, i, a[0]), b, half_extents(others, j, a[0]), rounding)
    return pair_gap(body_of(bodies, vertices, i, a), body_of(others, points, j, b), reach, rounding)


@kernel
def gap_is_searched(bodies, vertices, i, others, points, j):
    """Whether ``rows_gap`` is a search, which finds the distance itself if reach is less than that; else it may be below it."""
    if vertices is None or points is None:
        return False
    kind, other = int(bodies[i, SHAPE]), int(others[j, SHAPE])
    return is_searched(min(kind, other), max(kind, other))


@kernel
def ball_distance(bodies, i, a, others, j, b):
    """The signed distance of the bounding balls of two rows, at poses a and b: a lower bound of that of the bodies."""
    d = minus(origin(a), origin(b))
    return sqrt(dot(d, d)) - BALLS * (bodies[i, REACH] + others[j, REACH])


@kernel
def balls_overlap(bodies, i, a, others, j, b):
    """True where the bounding balls of two rows, at poses a and b, overlap; elsewhere the bodies do not."""
    reach = BALLS * (bodies[i, REACH] + others[j, REACH])
    d = minus(origin(a), origin(b))
    return dot(d, d) <= reach * reach


@kernel
def solid_at(scene, w, like):
    """The row of solid w in the table of objects, and its pose as numbers of the kind of ``like``."""
    if w < FIRST_BALL:
        return w, constant_pose(scene.objects, w, like)
    k, lane = (w - FIRST_BALL) // WIDTH, (w - FIRST_BALL) % WIDTH
    first = NODE_ROWS * (k // 2)
    i, row = first + 3 * (k % 2), int(scene.nodes[first + CHILD, BALL_ROW])
    x, y, z = (
        splat(scene.nodes[i, lane], like),
        splat(scene.nodes[i + 1, lane], like),
        splat(scene.nodes[i + 2, lane], like),
    )
    one, none = splat(1.0, like), splat(0.0, like)
    return row, (one, none, none, x, none, one, none, y, none, none, one, z)


@kernel
def may_touch(scene, k, row):
    """Whether body k may touch the object of a row of the table: their contact is no collision."""
    return scene.may_touch[k, int(scene.objects[row, TOUCH_SET])]


@kernel
def is_excepted(scene, apart, k, row):
    """Whether body k is one of those that may touch the object of a row by ``apart``."""
    found = False
    if apart is not None:
        number, pairs = int(scene.objects[row, OBJECT]), apart.touching
        for m in range(pairs.shape[0]):
            found = found or (pairs[m, PAIR_BODY] == k and pairs[m, PAIR_OBJECT] == number)
    return found


@kernel
def wider_by(scene, apart, row):
    """How much farther than a margin the object of a row has to be [m]."""
    return 0.0 if apart is None else apart.wider[int(scene.objects[row, OBJECT])]


@kernel
def widest(apart, back):
    """The greatest of these of all objects, with back = 1, or of those in the BVH, with back = 2 [m]."""
    return 0.0 if apart is None else apart.wider[-back]


@kernel
def half_extents(bodies, i, like):
    """The half extents of a row of a table of bodies."""
    c = HALF_EXTENTS
    return splat(bodies[i, c], like), splat(bodies[i, c + 1], like), splat(bodies[i, c + 2], like)
