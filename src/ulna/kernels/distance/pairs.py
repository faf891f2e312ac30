"""Computes signed distance, witness points, normal and overlap of two bodies of any shapes.

A body is (kind, pose, size, vertices): a kind of ``layout``; a pose; four numbers, the half extents and the radius; and the
points of a hull, a plain array of shape (n, 3), else of shape (0, 3). The kind and the points are the same in all lanes; pose
and size are numbers, so that lanes can be eight configurations, or eight bodies of one kind.

A contact is (signed distance [m], witness_a, witness_b, normal): the last three are vectors in the frame of the poses.
The normal is a unit vector from a to b, and witness_b - witness_a = signed distance * normal.

Two bodies overlap unless it is certain that they are farther apart than ``CONTACT`` times their sizes: touching is contact. Their
distance is then zero, so that the sign of the distance agrees with the overlap test.

The scratch is three arrays, which the entry owns, of the shapes in ``epa.SCRATCH``.
"""

from ulna.engine.decorators import kernel, routine, shared_routine
from ulna.engine.lanes import any_lane, splat, where
from ulna.kernels.distance.box_distance import box_pair
from ulna.kernels.distance.box_sat import boxes_overlap, certain_gap
from ulna.kernels.distance.epa import with_penetration
from ulna.kernels.distance.gjk import core_bound, nearest_cores
from ulna.kernels.distance.support import support
from ulna.kernels.distance.swept_segments import point_box, point_cylinder, segment_segment, swept
from ulna.kernels.layout import (
    BOX,
    CAPSULE,
    CONTACT,
    CYLINDER,
    FIRST_VERTEX,
    HALF_EXTENTS,
    HALF_SPACE,
    N_VERTICES,
    RADIUS,
    SHAPE,
    SPHERE,
)
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.vectors import add_scaled, chosen, dot, minus, origin, rotate_inverse, scaled, transform, z_axis

_ANY = 1e300  # [m] a reach that every distance is within, so that a search ends in its first step


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
    """The contact of two bodies; NaN for two half-spaces, whose distance is not defined. Without scratch, only of closed form."""
    ordered = a[0] <= b[0]
    first, second = (a, b) if ordered else (b, a)
    kind_a, pose_a, size_a, vertices_a = first
    kind_b, pose_b, size_b, vertices_b = second
    if scratch is None:
        core = closed_core(kind_a, pose_a, box_of(first), vertices_a, kind_b, pose_b, box_of(second))
        below = core[0]
    elif is_searched(kind_a, kind_b):
        below, core = convex_distance(
            kind_a, pose_a, box_of(first), vertices_a, kind_b, pose_b, box_of(second), vertices_b, scratch
        )  # fmt: skip
    else:
        core = closed_core(kind_a, pose_a, box_of(first), vertices_a, kind_b, pose_b, box_of(second))
        below = core[0]
    distance, p, q, n = swept(core, size_a[3], size_b[3])
    touching = (below <= contact_reach(first, second)) & (distance > 0.0)
    distance, q = where(touching, 0.0, distance), chosen(touching, p, q)
    if ordered:
        return distance, p, q, n
    return distance, q, p, scaled(n, -1.0)


@kernel
def is_searched(kind_a, kind_b):
    """Whether the distance of two cores, the lower kind first, has no closed form; true of every kind not named here."""
    return not (kind_b <= BOX or kind_b == HALF_SPACE or (kind_a == SPHERE and kind_b == CYLINDER))


@kernel
def closed_core(kind_a, a, h, vertices_a, kind_b, b, g):
    """The contact of two cores in closed form, the lower kind first."""
    if kind_b == HALF_SPACE:
        return core_half_space(kind_a, a, h, vertices_a, b)
    if kind_b <= CAPSULE:
        return segment_segment(a, h[2], b, g[2])
    if kind_a == SPHERE and kind_b == BOX:
        return point_box(a, b, g)
    if kind_a == SPHERE and kind_b == CYLINDER:
        return point_cylinder(a, b, g)
    return box_pair(a, h, b, g)


@kernel
def core_half_space(kind, a, h, vertices, b):
    """The signed distance of a core at pose a from the half-space of pose b, the nearest points, and the normal from a to b."""
    n = z_axis(b)
    p = transform(a, support(kind, h, vertices, scaled(rotate_inverse(a, n), -1.0)))
    distance = dot(n, minus(p, origin(b)))
    return distance, p, add_scaled(p, -distance, n), scaled(n, -1.0)


@shared_routine
def convex_distance(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, scratch):
    """A lower bound of the distance, and the contact: by GJK, and by EPA where the cores overlap."""
    no_reach = splat(-1.0, a[0])
    below, distance, p, q, n, inside = nearest_cores(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, no_reach)
    contact = distance, p, q, n
    if any_lane(inside):
        contact = with_penetration(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, contact, where(inside, 1.0, 0.0), scratch)
    return below, contact


@kernel
def box_of(body):
    """The half extents of a body's core."""
    return body[2][0], body[2][1], body[2][2]


@kernel
def outer_box_of(body):
    """The half extents of a box that holds a body."""
    h, radius = body[2], body[2][3]
    return h[0] + radius, h[1] + radius, h[2] + radius


@kernel
def pair_overlap(a, b, wanted):
    """True where two bodies share a point. Cheaper than their distance where the kinds allow it.

    wanted: 1.0 where that is to be found; elsewhere, where it is 0.0, the result may be False. A search looks at the boxes that
    hold the bodies first, and only at the lanes in which these overlap.
    """
    first, second = (a, b) if a[0] <= b[0] else (b, a)
    if first[0] == BOX and second[0] == BOX:
        return boxes_overlap(first[1], box_of(first), second[1], box_of(second))
    reach = contact_reach(first, second)
    if is_searched(first[0], second[0]):
        near = (wanted > 0.0) & boxes_overlap(first[1], outer_box_of(first), second[1], outer_box_of(second))
        if not any_lane(near):
            return near
        far = where(near, reach, _ANY)
        return near & cores_within(
            first[0], first[1], box_of(first), first[3], second[0], second[1], box_of(second), second[3], far
        )
    return closed_core(first[0], first[1], box_of(first), first[3], second[0], second[1], box_of(second))[0] <= reach


@kernel
def contact_reach(a, b):
    """How far apart the cores of two bodies that touch may be [m]: the radii of their balls, and ``CONTACT`` of their sizes."""
    radii = a[2][3] + b[2][3]
    return radii + CONTACT * (radii + core_bound(a[2]) + core_bound(b[2]))


@shared_routine
def pair_gap(a, b, reach, rounding):
    """A lower bound of the distance of two bodies [m], up to a rounding [m], even where a search is not exact.

    It is the gap between the projections of the bodies on one direction, which is never more than the distance. The search for
    the direction ends once the bound exceeds reach [m]; that of the boxes round the cores comes first.
    """
    first, second = (a, b) if a[0] <= b[0] else (b, a)
    kind_a, pose_a, size_a, vertices_a = first
    kind_b, pose_b, size_b, vertices_b = second
    radii = size_a[3] + size_b[3]
    if is_searched(kind_a, kind_b):
        box_a, box_b = box_of(first), box_of(second)
        wide = certain_gap(pose_a, box_a, pose_b, box_b, rounding) - radii
        near = wide <= reach
        if not any_lane(near):
            return wide
        far = where(near, reach + radii, _ANY)
        below = nearest_cores(kind_a, pose_a, box_a, vertices_a, kind_b, pose_b, box_b, vertices_b, far)[0] - radii
        return maximum(wide, below)
    distance, _, _, n = closed_core(kind_a, pose_a, box_of(first), vertices_a, kind_b, pose_b, box_of(second))
    if kind_b == HALF_SPACE:
        return distance - radii
    p = transform(pose_a, support(kind_a, box_of(first), vertices_a, rotate_inverse(pose_a, n)))
    q = transform(pose_b, support(kind_b, box_of(second), vertices_b, scaled(rotate_inverse(pose_b, n), -1.0)))
    gap = dot(n, minus(q, p)) - radii
    if kind_b == BOX and kind_a == CAPSULE:
        return maximum(gap, certain_gap(pose_a, box_of(first), pose_b, box_of(second), rounding) - radii)
    return gap


@routine
def cores_within(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, reach):
    """True where two cores are no farther apart than a reach [m]: the search ends as soon as that is certain."""
    below, _, _, _, _, _ = nearest_cores(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, reach)
    return below <= reach
