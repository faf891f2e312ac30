"""Two bodies of any shapes: their signed distance, witness points and normal, and whether they overlap.

A body is (kind, pose, size, vertices): a kind of ``layout``; a pose; four numbers, the half extents and the radius; and the points
of a hull, a plain array of shape (n, 3), else of shape (0, 3). The kind and the points are the same in all lanes; pose and size are
numbers, so that lanes can be eight configurations, or eight bodies of one kind.

An answer is (signed distance [m], witness_a, witness_b, normal): three numbers each, in the frame in which the poses are given.
The normal is a unit vector from a to b, and witness_b - witness_a = signed distance * normal.

The scratch is an entry's: (rows, points, faces, edges), of PAIR_ROWS rows of numbers, and of the shapes that ``depth`` names.
"""

from ulna.kernels.box_box import boxes_overlap
from ulna.kernels.box_distance import box_pair
from ulna.kernels.compile import kernel, routine
from ulna.kernels.depth import deepened
from ulna.kernels.gjk import nearest_cores
from ulna.kernels.half_space import core_half_space
from ulna.kernels.lanes import any_lane, splat, where
from ulna.kernels.layout import BOX, CAPSULE, CYLINDER, FIRST_VERTEX, HALF_EXTENTS, HALF_SPACE, HULL, N_VERTICES, RADIUS, SHAPE, SPHERE
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
def pair_distance(a, b, scratch):
    """The answer for two bodies; NaN for two half-spaces, which have no distance to speak of."""
    if a[0] <= b[0]:
        return ordered_distance(a, b, scratch)
    distance, p, q, n = ordered_distance(b, a, scratch)
    return distance, q, p, times(n, -1.0)


@kernel
def ordered_distance(a, b, scratch):
    """The same, the kind of a not after that of b."""
    return swept(core_distance(a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], scratch), a[2][3], b[2][3])


@kernel
def core_distance(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, scratch):
    """The answer for two cores, each by the shortest way there is for its kind."""
    if kind_b == HALF_SPACE:
        return core_half_space(kind_a, a, h, vertices_a, b)
    if kind_b <= CAPSULE:
        return segment_segment(a, h[2], b, g[2])
    if kind_a == SPHERE and kind_b == BOX:
        return point_box(a, b, g)
    if kind_a == SPHERE and kind_b == CYLINDER:
        return point_cylinder(a, b, g)
    half_a, half_b = (h[0], h[1], h[2]), (g[0], g[1], g[2])
    if kind_b <= BOX:
        return box_pair(a, half_a, b, half_b)
    return convex_distance(kind_a, a, half_a, vertices_a, kind_b, b, half_b, vertices_b, scratch)


@routine
def convex_distance(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, scratch):
    """The answer by search: of the distance, and where the cores overlap of the depth."""
    no_reach = splat(-1.0, a[0])
    _, distance, p, q, n, inside = nearest_cores(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, no_reach)
    answer = distance, p, q, n
    if any_lane(inside):
        answer = deepened(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, answer, where(inside, 1.0, 0.0), scratch)
    return answer


@kernel
def box_of(body):
    """The half extents of a body's core."""
    return body[2][0], body[2][1], body[2][2]


@kernel
def pair_overlap(a, b, scratch):
    """True where two bodies share a point. Cheaper than their distance where the kinds allow it."""
    if a[0] <= b[0]:
        return ordered_overlap(a, b, scratch)
    return ordered_overlap(b, a, scratch)


@kernel
def ordered_overlap(a, b, scratch):
    """The same, the kind of a not after that of b."""
    if a[0] == BOX and b[0] == BOX:
        return boxes_overlap(a[1], box_of(a), b[1], box_of(b))
    if b[0] == CYLINDER and a[0] != SPHERE or b[0] == HULL:
        return cores_within(a[0], a[1], box_of(a), a[3], b[0], b[1], box_of(b), b[3], a[2][3] + b[2][3])
    return ordered_distance(a, b, scratch)[0] <= 0.0


@routine
def cores_within(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, reach):
    """True where two cores are no farther apart than a reach [m]: the search ends as soon as that is certain."""
    below, _, _, _, _, _ = nearest_cores(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, reach)
    return below <= reach
