"""Computes the poses of the robot's bodies at q, and the distance or overlap of two table rows.

Each table comes with its vertices. If either is None, all shapes are boxes. A scene of boxes, the most frequent, then compiles
without GJK and EPA, in a fraction of the time. The compiler removes the code after a test for None only if the tested value is an
argument of its own, not a field. So ``overlap_by``, ``contact_by`` and ``gap_by`` take the vertices beside the bodies.
"""

from ulna.engine.decorators import kernel, shared_routine
from ulna.engine.lanes import WIDTH, load, splat, sqrt
from ulna.kernels.chain.poses import frame_pose, tree_poses
from ulna.kernels.collision.collision_layout import BALL_ROW, CHILD, FIRST_BALL, NODE_ROWS, PAIR_BODY, PAIR_OBJECT
from ulna.kernels.collision.scene import Posed
from ulna.kernels.distance.box_distance import box_pair
from ulna.kernels.distance.box_sat import boxes_overlap, certain_gap
from ulna.kernels.distance.pairs import body_of, is_searched, pair_distance, pair_gap, pair_overlap
from ulna.kernels.layout import BOX, CONTACT, HALF_EXTENTS, OBJECT, REACH, SHAPE, TOUCH_SET
from ulna.kernels.spatial.se3 import constant_pose, store_pose
from ulna.kernels.spatial.vectors import dot, minus, origin

BALLS = 1.0 + 4.0 * CONTACT  # factor on bounding balls, so that the balls of bodies within the contact tolerance overlap


@kernel
def place_bodies(joints, bodies, q_rows, joint_rows, body_rows):
    """Write the pose of every body of the robot to body_rows."""
    tree_poses(joints, q_rows, joint_rows)
    for k in range(bodies.shape[0]):
        store_pose(body_rows, k, frame_pose(bodies, k, joint_rows, load(q_rows, 0)))


@kernel
def body_at(scene, k, a):
    """Body k of the robot, at pose a."""
    return Posed(scene.bodies, scene.vertices, k, a)


@kernel
def object_at(scene, row, b):
    """The object of a row, at pose b."""
    return Posed(scene.objects, scene.points, row, b)


@kernel
def rows_overlap(ours, theirs, wanted):
    """True where two bodies (``scene.Posed``) share a point.

    wanted: 1.0 where the result is needed; where it is 0.0, the result may be either. Boxes, the most frequent, are tested
    inline. Other shapes are tested by a call, which keeps the loops over boxes small.
    """
    return overlap_by(ours.vertices, theirs.vertices, ours, theirs, wanted)


@kernel
def overlap_by(vertices, points, ours, theirs, wanted):
    """``rows_overlap`` with the vertices of the two bodies as arguments."""
    if vertices is None or points is None:
        return box_rows_overlap(ours, theirs)
    if are_boxes(ours, theirs):
        return box_rows_overlap(ours, theirs)
    return convex_overlap(ours, theirs, wanted)


@kernel
def are_boxes(ours, theirs):
    """Whether two bodies are boxes."""
    return int(ours.table[ours.row, SHAPE]) == BOX and int(theirs.table[theirs.row, SHAPE]) == BOX


@kernel
def box_rows_overlap(ours, theirs):
    """``rows_overlap`` for boxes."""
    return boxes_overlap(ours.pose, half_of(ours, ours.pose[0]), theirs.pose, half_of(theirs, ours.pose[0]))


@shared_routine
def convex_overlap(ours, theirs, wanted):
    """``rows_overlap`` for convex shapes of any kind."""
    return pair_overlap(convex_body(ours), convex_body(theirs), wanted)


@kernel
def convex_body(posed):
    """A row at a pose as a convex body (``pairs``)."""
    return body_of(posed.table, posed.vertices, posed.row, posed.pose)


@kernel
def rows_contact(ours, theirs, scratch):
    """The contact (``pairs``) of two bodies."""
    return contact_by(ours.vertices, theirs.vertices, ours, theirs, scratch)


@kernel
def contact_by(vertices, points, ours, theirs, scratch):
    """``rows_contact`` with the vertices of the two bodies as arguments."""
    if vertices is None or points is None:
        return box_pair(ours.pose, half_of(ours, ours.pose[0]), theirs.pose, half_of(theirs, ours.pose[0]))
    return pair_distance(convex_body(ours), convex_body(theirs), scratch)


@kernel
def rows_gap(ours, theirs, reach, rounding):
    """A lower bound of the distance of two bodies [m], up to a rounding [m].

    The bound need not be tight once it exceeds reach [m].
    """
    return gap_by(ours.vertices, theirs.vertices, ours, theirs, reach, rounding)


@kernel
def gap_by(vertices, points, ours, theirs, reach, rounding):
    """``rows_gap`` with the vertices of the two bodies as arguments."""
    if vertices is None or points is None:
        return box_rows_gap(ours, theirs, rounding)
    if are_boxes(ours, theirs):
        return box_rows_gap(ours, theirs, rounding)
    return pair_gap(convex_body(ours), convex_body(theirs), reach, rounding)


@kernel
def box_rows_gap(ours, theirs, rounding):
    """``rows_gap`` of the boxes round two cores."""
    return certain_gap(ours.pose, half_of(ours, ours.pose[0]), theirs.pose, half_of(theirs, ours.pose[0]), rounding)


@kernel
def gap_is_searched(ours, theirs):
    """Whether ``rows_gap`` is a search. A search ends at the exact distance, unless the bound exceeds reach first.

    Without a search, the bound may stay below the distance.
    """
    if ours.vertices is None or theirs.vertices is None:
        return False
    kind, other = int(ours.table[ours.row, SHAPE]), int(theirs.table[theirs.row, SHAPE])
    return is_searched(min(kind, other), max(kind, other))


@kernel
def ball_distance(ours, theirs):
    """The signed distance of the bounding balls of two bodies: a lower bound of the bodies' distance."""
    d = minus(origin(ours.pose), origin(theirs.pose))
    return sqrt(dot(d, d)) - BALLS * (ours.table[ours.row, REACH] + theirs.table[theirs.row, REACH])


@kernel
def balls_overlap(ours, theirs):
    """True where the bounding balls of two bodies overlap; elsewhere the bodies do not."""
    reach = BALLS * (ours.table[ours.row, REACH] + theirs.table[theirs.row, REACH])
    d = minus(origin(ours.pose), origin(theirs.pose))
    return dot(d, d) <= reach * reach


@kernel
def solid_at(scene, w, like):
    """Solid w at its pose, in numbers of the same type as ``like``."""
    if w < FIRST_BALL:
        return object_at(scene, w, constant_pose(scene.objects, w, like))
    k, lane = (w - FIRST_BALL) // WIDTH, (w - FIRST_BALL) % WIDTH
    first = NODE_ROWS * (k // 2)
    i, row = first + 3 * (k % 2), int(scene.nodes[first + CHILD, BALL_ROW])
    x, y, z = (
        splat(scene.nodes[i, lane], like),
        splat(scene.nodes[i + 1, lane], like),
        splat(scene.nodes[i + 2, lane], like),
    )
    one, none = splat(1.0, like), splat(0.0, like)
    return object_at(scene, row, (one, none, none, x, none, one, none, y, none, none, one, z))


@kernel
def may_touch(scene, k, row):
    """Whether body k may touch the object of a row: their contact is no collision."""
    return scene.may_touch[k, int(scene.objects[row, TOUCH_SET])]


@kernel
def is_excepted(scene, margins, k, row):
    """Whether ``margins`` allows body k to touch the object of a row."""
    is_listed = False
    if margins is not None:
        number, pairs = int(scene.objects[row, OBJECT]), margins.touching
        for m in range(pairs.shape[0]):
            is_listed = is_listed or (pairs[m, PAIR_BODY] == k and pairs[m, PAIR_OBJECT] == number)
    return is_listed


@kernel
def extra_margin(scene, margins, row):
    """The margin of a row's object in excess of the common margin [m]."""
    return 0.0 if margins is None else margins.extra[int(scene.objects[row, OBJECT])]


@kernel
def max_extra_margin(margins, from_end):
    """The maximum extra margin [m] of all objects (from_end = 1), or of those in the BVH (from_end = 2)."""
    return 0.0 if margins is None else margins.extra[-from_end]


@kernel
def half_of(posed, like):
    """The half extents of a body."""
    return half_extents(posed.table, posed.row, like)


@kernel
def half_extents(bodies, i, like):
    """The half extents of a row of a table of bodies."""
    c = HALF_EXTENTS
    return splat(bodies[i, c], like), splat(bodies[i, c + 1], like), splat(bodies[i, c + 2], like)
