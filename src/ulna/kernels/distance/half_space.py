"""Computes the signed distance of a convex shape from a half-space."""

from ulna.engine.decorators import kernel
from ulna.kernels.distance.support import support
from ulna.kernels.spatial.vectors import add_scaled, dot, minus, origin, rotate_inverse, scaled, transform, z_axis


@kernel
def core_half_space(kind, a, h, vertices, b):
    """The signed distance of a core at pose a from the half-space of pose b, the nearest points, and the normal from a to b."""
    n = z_axis(b)
    p = transform(a, support(kind, h, vertices, scaled(rotate_inverse(a, n), -1.0)))
    distance = dot(n, minus(p, origin(b)))
    return distance, p, add_scaled(p, -distance, n), scaled(n, -1.0)
