"""Computes the signed distance of spheres and capsules: points and segments swept by a ball.

Every function returns the contact of two cores: signed distance [m], nearest points, and unit normal from a to b, in the
poses' reference frame. ``swept`` then adds the balls.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt, where
from ulna.kernels.spatial.elementary import clamp, maximum
from ulna.kernels.spatial.vectors import (
    add_scaled,
    chosen,
    cross,
    dot,
    minus,
    origin,
    rotate,
    scaled,
    transform,
    transform_inverse,
    x_axis,
    z_axis,
)

_NEAR = 1e-12  # [m] two points this close define no normal
_PARALLEL = 1e-16  # the square of the sine of an angle; below it any point of one segment is as good to start from


@kernel
def swept(core, radius_a, radius_b):
    """The contact of two cores swept by balls: both surfaces approach along the normal."""
    distance, p, q, n = core
    return distance - radius_a - radius_b, add_scaled(p, radius_a, n), add_scaled(q, -radius_b, n), n


@kernel
def contact_of_points(p, q, otherwise):
    """The contact of two cores from their nearest points; ``otherwise`` is the normal where these coincide."""
    v = minus(q, p)
    distance = sqrt(dot(v, v))
    near = distance < _NEAR
    return distance, p, q, chosen(near, otherwise, scaled(v, 1.0 / where(near, 1.0, distance)))


@kernel
def segment_segment(a, half_a, b, half_b):
    """The contact of two segments along the z axes of poses a and b.

    A half length of zero makes a point.

    1. Take the point of line a nearest to line b, clamped to segment a; the point of line b nearest to it, clamped to segment b;
       and again the point of a nearest to this one (Ericson, Real-Time Collision Detection, 2005, section 5.1.9).
    2. If they intersect, they separate fastest along their common perpendicular; for parallel ones along any perpendicular.
    """
    u, v, r = z_axis(a), z_axis(b), minus(origin(a), origin(b))
    n = cross(u, v)
    square, cosine = dot(n, n), dot(u, v)
    crossed = square > _PARALLEL
    along_a, along_b = dot(u, r), dot(v, r)
    s = clamp(where(crossed, (cosine * along_b - along_a) / where(crossed, square, 1.0), 0.0), half_a)
    t = clamp(along_b + cosine * s, half_b)
    s = clamp(cosine * t - along_a, half_a)
    perpendicular = chosen(crossed, scaled(n, 1.0 / sqrt(where(crossed, square, 1.0))), x_axis(a))
    return contact_of_points(add_scaled(origin(a), s, u), add_scaled(origin(b), t, v), perpendicular)


@kernel
def point_box(a, b, h):
    """The contact of the origin of pose a with the box at pose b.

    The nearest point is the clamped origin, or, from inside, the projection on the nearest face.
    """
    c = transform_inverse(b, origin(a))
    p = clamp(c[0], h[0]), clamp(c[1], h[1]), clamp(c[2], h[2])
    x, y, z = abs(c[0]) - h[0], abs(c[1]) - h[1], abs(c[2]) - h[2]
    by_x, by_y = (x >= y) & (x >= z), y >= z
    side_x, side_y, side_z = side(c[0]), side(c[1]), side(c[2])
    zero = 0.0 * x
    face = chosen(by_x, (side_x, zero, zero), chosen(by_y, (zero, side_y, zero), (zero, zero, side_z)))
    return contact_with_point(a, b, c, p, maximum(maximum(x, y), z), face)


@kernel
def point_cylinder(a, b, h):
    """The contact of the origin of pose a with the cylinder at pose b along z, as in ``point_box``.

    It is computed in the half plane of radius and height.
    """
    c = transform_inverse(b, origin(a))
    radius = sqrt(c[0] * c[0] + c[1] * c[1])
    off_axis = radius > 0.0
    cosine, sine = where(off_axis, c[0], 1.0) / where(off_axis, radius, 1.0), c[1] / where(off_axis, radius, 1.0)
    around, above = radius - h[0], abs(c[2]) - h[2]
    kept = clamp(radius, h[0])
    p = kept * cosine, kept * sine, clamp(c[2], h[2])
    zero = 0.0 * radius
    outwards = chosen(around >= above, (cosine, sine, zero), (zero, zero, side(c[2])))
    return contact_with_point(a, b, c, p, maximum(around, above), outwards)


@kernel
def side(x):
    """The sign of x as 1 or -1; 1 for zero."""
    return where(x < 0.0, -1.0, 1.0)


@kernel
def contact_with_point(a, b, c, p, height, outwards):
    """The contact of a point c with a body at pose b, from the body's nearest point p.

    c and p are in the body's frame.

    height: The signed distance of c from its nearest face, negative inside. outwards: The normal of that face. Inside it is the
    direction of the shortest way out.
    """
    v = minus(p, c)
    distance = sqrt(dot(v, v))
    within = distance < _NEAR
    n = chosen(within, scaled(outwards, -1.0), scaled(v, 1.0 / where(within, 1.0, distance)))
    signed = where(within, height, distance)
    return signed, origin(a), transform(b, chosen(within, add_scaled(c, -signed, outwards), p)), rotate(b, n)
