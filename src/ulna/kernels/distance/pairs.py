"""Computes signed distance, witness points, normal and overlap of two bodies of any shapes.

A body is a ``Body``: a core at a pose, swept by a ball. Its kind and its vertices are the same in all lanes. Pose and size are
numbers, so lanes can be eight configurations, or eight bodies of one kind.

A contact is (signed distance [m], witness_a, witness_b, normal): the last three are vectors in the poses' reference frame. The
normal is a unit vector from a to b, and witness_b - witness_a = signed distance * normal.

Two bodies overlap unless they are certainly farther apart than ``CONTACT`` times their sizes: touching is contact. Their distance
is then zero, so that the sign of the distance agrees with the overlap test.

The scratch is three arrays, which the entry owns: points, faces and edges for ``epa``.
"""

from ulna.engine.decorators import kernel, routine, shared_routine
from ulna.engine.lanes import any_lane, splat, where
from ulna.kernels.distance.body_records import Body, Core
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

_ANY = 1e300  # [m] above every distance, so that a search ends in its first step


@kernel
def body_of(bodies, vertices, i, pose):
    """Row i of a table of bodies, at a pose."""
    like, c = pose[0], HALF_EXTENTS
    half = splat(bodies[i, c], like), splat(bodies[i, c + 1], like), splat(bodies[i, c + 2], like)
    first = int(bodies[i, FIRST_VERTEX])
    core = Core(int(bodies[i, SHAPE]), half, vertices[first : first + int(bodies[i, N_VERTICES])])
    return Body(pose, core, splat(bodies[i, RADIUS], like))


@kernel
def pair_distance(a, b, scratch):
    """The contact of two bodies; NaN for two half-spaces, whose distance is undefined.

    Without scratch, only pairs with a closed form are allowed.
    """
    ordered = a.core.kind <= b.core.kind
    first, second = (a, b) if ordered else (b, a)
    if scratch is None:
        core = closed_core(first.pose, first.core, second.pose, second.core)
        below = core[0]
    elif is_searched(first.core.kind, second.core.kind):
        below, core = convex_distance(first.pose, first.core, second.pose, second.core, scratch)
    else:
        core = closed_core(first.pose, first.core, second.pose, second.core)
        below = core[0]
    distance, p, q, n = swept(core, first.radius, second.radius)
    touching = (below <= contact_reach(first, second)) & (distance > 0.0)
    distance, q = where(touching, 0.0, distance), chosen(touching, p, q)
    if ordered:
        return distance, p, q, n
    return distance, q, p, scaled(n, -1.0)


@kernel
def is_searched(kind_a, kind_b):
    """Whether the distance of two cores, the lower kind first, has no closed form. Kinds not named here have none."""
    return not (kind_b <= BOX or kind_b == HALF_SPACE or (kind_a == SPHERE and kind_b == CYLINDER))


@kernel
def closed_core(a, core_a, b, core_b):
    """The contact of two cores at poses a and b in closed form, the lower kind first."""
    h, g = core_a.half, core_b.half
    if core_b.kind == HALF_SPACE:
        return core_half_space(a, core_a, b)
    if core_b.kind <= CAPSULE:
        return segment_segment(a, h[2], b, g[2])
    if core_a.kind == SPHERE and core_b.kind == BOX:
        return point_box(a, b, g)
    if core_a.kind == SPHERE and core_b.kind == CYLINDER:
        return point_cylinder(a, b, g)
    return box_pair(a, h, b, g)


@kernel
def core_half_space(a, core, b):
    """The contact of a core at pose a with a half-space at pose b.

    The normal is from a to b.
    """
    n = z_axis(b)
    p = transform(a, support(core, scaled(rotate_inverse(a, n), -1.0)))
    distance = dot(n, minus(p, origin(b)))
    return distance, p, add_scaled(p, -distance, n), scaled(n, -1.0)


@shared_routine
def convex_distance(a, core_a, b, core_b, scratch):
    """A lower bound of the distance of two cores, and their contact: by GJK, or EPA for an overlap."""
    below, distance, p, q, n, inside = nearest_cores(a, core_a, b, core_b, splat(-1.0, a[0]))
    contact = distance, p, q, n
    if any_lane(inside):
        contact = with_penetration(a, core_a, b, core_b, contact, where(inside, 1.0, 0.0), scratch)
    return below, contact


@kernel
def outer_half(body):
    """The half extents of a box that holds a body."""
    h, radius = body.core.half, body.radius
    return h[0] + radius, h[1] + radius, h[2] + radius


@kernel
def pair_overlap(a, b, wanted):
    """True where two bodies share a point. Cheaper than their distance for some kinds.

    wanted: 1.0 where the result is needed; where it is 0.0, the result may be False. A search first tests the boxes around the
    bodies, and then takes only the lanes where these overlap.
    """
    first, second = (a, b) if a.core.kind <= b.core.kind else (b, a)
    if first.core.kind == BOX and second.core.kind == BOX:
        return boxes_overlap(first.pose, first.core.half, second.pose, second.core.half)
    reach = contact_reach(first, second)
    if is_searched(first.core.kind, second.core.kind):
        near = (wanted > 0.0) & boxes_overlap(first.pose, outer_half(first), second.pose, outer_half(second))
        if not any_lane(near):
            return near
        return near & cores_within(first.pose, first.core, second.pose, second.core, where(near, reach, _ANY))
    return closed_core(first.pose, first.core, second.pose, second.core)[0] <= reach


@kernel
def contact_reach(a, b):
    """The maximum distance of two touching bodies' cores [m]: their radii, and ``CONTACT`` of their sizes."""
    radii = a.radius + b.radius
    return radii + CONTACT * (radii + core_bound(a.core.half) + core_bound(b.core.half))


@shared_routine
def pair_gap(a, b, reach, rounding):
    """A lower bound of two bodies' distance [m], up to a rounding [m], even if the search is inexact.

    It is the gap between the projections of the bodies on one direction, which is never more than the distance. The gap of the
    boxes around the cores comes first. The search for a better direction ends once the bound exceeds reach [m].
    """
    first, second = (a, b) if a.core.kind <= b.core.kind else (b, a)
    (a, core_a, _), (b, core_b, _), radii = first, second, first.radius + second.radius
    if is_searched(core_a.kind, core_b.kind):
        wide = certain_gap(a, core_a.half, b, core_b.half, rounding) - radii
        near = wide <= reach
        if not any_lane(near):
            return wide
        below = nearest_cores(a, core_a, b, core_b, where(near, reach + radii, _ANY))[0] - radii
        return maximum(wide, below)
    distance, _, _, n = closed_core(a, core_a, b, core_b)
    if core_b.kind == HALF_SPACE:
        return distance - radii
    p = transform(a, support(core_a, rotate_inverse(a, n)))
    q = transform(b, support(core_b, scaled(rotate_inverse(b, n), -1.0)))
    gap = dot(n, minus(q, p)) - radii
    if core_b.kind == BOX and core_a.kind == CAPSULE:
        return maximum(gap, certain_gap(a, core_a.half, b, core_b.half, rounding) - radii)
    return gap


@routine
def cores_within(a, core_a, b, core_b, reach):
    """True where two cores are at most a reach [m] apart. The search ends as soon as this is decided."""
    return nearest_cores(a, core_a, b, core_b, reach)[0] <= reach
