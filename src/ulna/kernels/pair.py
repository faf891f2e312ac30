"""Two bodies of any shapes: their signed distance, witness points and normal, and whether they overlap.

A body is (kind, pose, size, vertices): a kind of ``layout``; a pose; four numbers, the half extents and the radius; and the points
of a hull, a plain array of shape (n, 3), else of shape (0, 3). The kind and the points are the same in all lanes; pose and size are
numbers, so that lanes can be eight configurations, or eight bodies of one kind.

An answer is (signed distance [m], witness_a, witness_b, normal): three numbers each, in the frame in which the poses are given.
The normal is a unit vector from a to b, and witness_b - witness_a = signed distance * normal.
"""

from ulna.kernels.box_box import boxes_overlap
from ulna.kernels.box_distance import box_pair
from ulna.kernels.compile import kernel, routine
from ulna.kernels.half_space import core_half_space
from ulna.kernels.lanes import splat
from ulna.kernels.layout import BOX, CAPSULE, CYLINDER, FIRST_VERTEX, HALF_EXTENTS, HALF_SPACE, N_VERTICES, RADIUS, SHAPE, SPHERE
from ulna.kernels.segments import point_box, point_cylinder, segment_segment, swept
from ulna.kernels.vectors import times


@kernel
def body_of(bodies, vertices, i, pose):
    """Row i of a table of bodies, at a pose."""
    like, c = pose[0], HALF_EXTENTS
    size = (
        splat(bodies[i, c], like), splat(bodies[i, c + 1], like), splat(bodies[i, c + 2], like), splat(bodies[i, RADIUS], like),
    )  # fmt: skip
    first = int(bodies[i, FIRST_VERTEX])
    return int(bodies[i, SHAPE]), pose, size, vertices[first : first + int(bodies[i, N_VERTICES])]


@kernel
def pair_distance(a, b):
    """The answer for two bodies; NaN for two half-spaces, which have no distance to speak of."""
    if a[0] <= b[0]:
        return ordered_distance(a, b)
    distance, p, q, n = ordered_distance(b, a)
    return distance, q, p, times(n, -1.0)


@kernel
def ordered_distance(a, b):
    """The same, the kind of a not after that of b."""
    return swept(core_distance(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]), a[2][3], b[2][3])


@routine
def core_distance(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b):
    """The answer for two cores, each by the shortest way there is for its kind."""
    if kind_b == HALF_SPACE:
        return core_half_space(kind_a, a, h, vertices_a, b)
    if kind_b <= CAPSULE:
        return segment_segment(a, h[2], b, g[2])
    if kind_a == SPHERE and kind_b == BOX:
        return point_box(a, b, g)
    if kind_a == SPHERE and kind_b == CYLINDER:
        return point_cylinder(a, b, g)
    return box_pair(a, (h[0], h[1], h[2]), b, (g[0], g[1], g[2]))


@kernel
def pair_overlap(a, b):
    """True where two bodies share a point. Cheaper than their distance where the kinds allow it."""
    if a[0] == BOX and b[0] == BOX:
        return boxes_overlap(a[1], (a[2][0], a[2][1], a[2][2]), b[1], (b[2][0], b[2][1], b[2][2]))
    return pair_distance(a, b)[0] <= 0.0
