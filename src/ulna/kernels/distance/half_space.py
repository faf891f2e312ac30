"""Computes the signed distance of a convex shape from a half-space. Used by ``pairs``."""

from ulna.engine.decorators import kernel
from ulna.kernels.distance.support import support
from ulna.kernels.spatial.vectors import axis, dot, minus, origin, place, step, times, turn_into


@kernel
def core_half_space(kind, a, h, vertices, b):
    """The signed distance of a core at pose a from the half-space of pose b, the nearest points, and the normal from a to b."""
    n = axis(b, 2)
    p = place(a, support(kind, h, vertices, times(turn_into(a, n), -1.0)))
    distance = dot(n, minus(p, origin(b)))
    return distance, p, step(p, -distance, n), times(n, -1.0)
