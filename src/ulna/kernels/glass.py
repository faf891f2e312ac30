"""Panes that are seen through, laid over a picture: each pixel takes of their colour as much as of it they cover."""

from ulna.kernels.compile import entry, kernel
from ulna.kernels.kinds import LIGHT, MATRIX, NEARNESS
from ulna.kernels.lanes import sqrt
from ulna.kernels.raster import row, span, twice_area, weights

_EDGE = 1.1  # pixels: the width of the line along a pane's edges
_EDGE_HOLDS = 0.6  # of what a pane lets through, its edge holds back so much


@entry((MATRIX, MATRIX, NEARNESS, LIGHT))
def lay_panes(points, paints, nearness, light):
    """Lay flat panes of four corners over the light of a picture, one after the other.

    1. For each pixel within a pane's bounds, of its samples that lie in the pane with nothing drawn nearer: the sum of the pane's
       opacities there, which are higher along its edges.
    2. The pixel gives up so much of its light for the pane's.

    Args:
        points: Raster coordinates of the corners, shape (4 n, 3), as in ``kernels.raster``: four in turn.
        paints: Red, green, blue (linear) and opacity of each pane, shape (n, 4).
        nearness: What was drawn before, shape (m * height, m * width).
        light: Shape (height, width, 3); written to.
    """
    height, width = light.shape[0], light.shape[1]
    m = nearness.shape[0] // height
    for k in range(paints.shape[0]):
        a, b, c, d = row(points, 4 * k), row(points, 4 * k + 1), row(points, 4 * k + 2), row(points, 4 * k + 3)
        if min(a[2], b[2], c[2], d[2]) > 0.0:
            left, right = span(min(a[0], b[0], c[0], d[0]), max(a[0], b[0], c[0], d[0]), m * width)
            top, bottom = span(min(a[1], b[1], c[1], d[1]), max(a[1], b[1], c[1], d[1]), m * height)
            for i in range(top // m, (bottom + m - 1) // m):
                for j in range(left // m, (right + m - 1) // m):
                    held = 0.0
                    for y in range(m * i, m * i + m):
                        for x in range(m * j, m * j + m):
                            held += held_back(a, b, c, d, x + 0.5, y + 0.5, nearness[y, x], paints[k, 3], _EDGE * m)
                    if held > 0.0:
                        part = held / (m * m)
                        for channel in range(3):
                            light[i, j, channel] += part * (paints[k, channel] - light[i, j, channel])


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
