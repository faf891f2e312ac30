"""Computes how much of the light behind a translucent pane it covers."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import sqrt
from ulna.kernels.render.raster import twice_area, weights

_EDGE = 1.1  # pixels: the width of the line along a pane's edges
_EDGE_HOLDS = 0.6  # of what a pane lets through, its edge holds back so much


@kernel
def held_back(a, b, c, d, x, y, nearest, opacity, edge):
    """How much of the light behind the place (x, y) a pane holds back: nothing outside it, or behind what is nearest there."""
    near, margin = half_pane(a, b, c, x, y)
    if margin < 0.0:
        near, margin = half_pane(c, d, a, x, y)
    if margin < 0.0 or near <= nearest:
        return 0.0
    return opacity + (1.0 - opacity) * _EDGE_HOLDS if margin < edge else opacity


@kernel
def half_pane(a, b, c, x, y):
    """The nearness of the half a, b, c of a pane at (x, y), and how far inside the pane's edges a b and b c that is."""
    area = twice_area(a, b, c)
    if area == 0.0:
        return 0.0, -1.0
    u, v = weights(a, b, c, area, x, y)
    w = 1.0 - u - v
    inside = min(u * abs(area) / length(b, c), w * abs(area) / length(a, b))
    return u * a[2] + v * b[2] + w * c[2], inside if v >= 0.0 else -1.0


@kernel
def length(a, b):
    """How far apart two places of the raster are."""
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]))
