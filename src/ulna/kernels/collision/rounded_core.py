"""Computes the distance of a point from the box round a body's core.

A body is a core swept by a ball of RADIUS (``kernels.layout``). The smallest box that holds the core is the core itself for a
sphere, a capsule and a box: then the distance from it, less the radius, is that of the body. Else it is a lower bound.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat
from ulna.kernels.collision.ball_motion import along
from ulna.kernels.layout import BOX, HALF_EXTENTS, HALF_SPACE, RADIUS, SHAPE, SPHERE
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import minus, origin, rotate_inverse, transform_inverse


@kernel
def core_offset(p, others, j, b):
    """From the smallest box that holds the core of body j, at pose b, to a point, as the body's frame sees it; 0 within [m].

    A sphere's core is its centre; it is seen from the frame of p. That of a half-space is the half-space.
    """
    if int(others[j, SHAPE]) == SPHERE:
        return minus(p, origin(b))
    x = transform_inverse(b, p)
    if int(others[j, SHAPE]) == HALF_SPACE:
        none = splat(0.0, x[2])
        return none, none, maximum(x[2], 0.0)
    c = HALF_EXTENTS
    return beyond(x[0], others[j, c]), beyond(x[1], others[j, c + 1]), beyond(x[2], others[j, c + 2])


@kernel
def core_slope(e, v, others, j, b):
    """How fast the length of ``core_offset``, e, changes where the point has the velocity v; 0 where it is 0."""
    return along(e, v if int(others[j, SHAPE]) == SPHERE else rotate_inverse(b, v))


@kernel
def core_radius(others, j):
    """How far body j is round its core [m]: a point at least so far from the core is outside of it."""
    return 0.0 if int(others[j, SHAPE]) == HALF_SPACE else others[j, RADIUS]


@kernel
def beyond(x, extent):
    """How far x is beyond -extent or extent, with its sign; 0 between."""
    return x - minimum(maximum(x, -extent), extent)


@kernel
def has_exact_ball(kind, other):
    """Whether the distance of a body's bounding ball from the box round another's core is that of the two bodies."""
    return kind == SPHERE and (other <= BOX or other == HALF_SPACE)
