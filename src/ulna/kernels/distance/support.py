"""Computes the support point of a core: its farthest point along a direction."""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, sqrt, where
from ulna.kernels.layout import BOX, CYLINDER, HULL
from ulna.kernels.spatial.vectors import chosen, dot, scaled


@kernel
def support(core, d):
    """The farthest point of a core along d. Points and segments are boxes with zero extents."""
    if core.kind <= BOX:
        return box_support(core.half, d)
    if core.kind == CYLINDER:
        return cylinder_support(core.half, d)
    if core.kind == HULL:
        return hull_support(core.vertices, d)
    return scaled(d, np.nan)  # a half-space has no farthest point


@kernel
def box_support(h, d):
    """The corner of a box on the side of d."""
    return where(d[0] < 0.0, -h[0], h[0]), where(d[1] < 0.0, -h[1], h[1]), where(d[2] < 0.0, -h[2], h[2])


@kernel
def cylinder_support(h, d):
    """The rim point of a cylinder on the side of d; an end's center if d is axial."""
    across = sqrt(d[0] * d[0] + d[1] * d[1])
    tilted = across > 0.0
    scale = where(tilted, h[0], 0.0) / where(tilted, across, 1.0)
    return scale * d[0], scale * d[1], where(d[2] < 0.0, -h[2], h[2])


@kernel
def hull_support(vertices, d):
    """The farthest vertex along d, by a linear search."""
    best = vertex(vertices, 0, d[0])
    farthest = dot(best, d)
    for k in range(1, vertices.shape[0]):
        p = vertex(vertices, k, d[0])
        height = dot(p, d)
        farther = height > farthest
        farthest, best = where(farther, height, farthest), chosen(farther, p, best)
    return best


@kernel
def vertex(vertices, k, like):
    """Vertex k as three numbers."""
    return splat(vertices[k, 0], like), splat(vertices[k, 1], like), splat(vertices[k, 2], like)
