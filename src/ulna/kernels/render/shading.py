"""Computes the light of one sample from its triangle, and the share that a translucent pane in front absorbs."""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.render.illumination import floor_light, ray, surface_light
from ulna.kernels.render.raster import corners, row, twice_area, weights
from ulna.kernels.render.render_layout import NOTHING
from ulna.kernels.spatial.vectors import add_scaled, dot, plus, scaled

_SAME_DEPTH, _SAME_TURN = 0.02, 0.95  # two samples within these differences show the same piece of surface
EDGE = 1.1  # pixels: the width of the line along a pane's edges
_EDGE_HOLDS = 0.6  # share of the light behind a pane that its edge absorbs in addition


@kernel
def uniform(numbers, nearness, skin, n, top, left):
    """True where the samples of a pixel show one piece of surface, or all of them none."""
    normals, colors, _, owners = skin
    first, near = numbers[top, left], nearness[top, left]
    for i in range(top, top + n):
        for j in range(left, left + n):
            k = numbers[i, j]
            if k != first:
                if min(k, first) <= NOTHING or owners[k] != owners[first] or colors[k, 0] != colors[first, 0]:
                    return False
                if dot(row(normals, 3 * k), row(normals, 3 * first)) < _SAME_TURN:
                    return False
                if abs(nearness[i, j] - near) > _SAME_DEPTH * near:
                    return False
    return True


@routine
def sample_light(raster, skin, turns, camera, lighting, k, place):
    """The light behind a place (x, y) of the raster, where triangle k is seen, or none.

    raster, lighting: as ``Raster`` and ``Lighting`` of ``viewer.film.entries.rendering``.
    """
    (x, y), (sun, shadows, floor) = place, lighting
    if k == NOTHING:
        return floor_light(camera, sun, shadows, floor, x, y)
    normals, colors, glow, owners = skin
    if glow[k] > 0.0:
        return scaled(row(colors, k), glow[k])
    a, b, c = corners(raster.points, raster.triangles, k)
    u, v = weights(a, b, c, twice_area(a, b, c), x, y)
    near = c[2] + u * (a[2] - c[2]) + v * (b[2] - c[2])
    u, v = u * a[2] / near, v * b[2] / near  # the weights in space
    n = plus(
        plus(scaled(row(normals, 3 * k), u), scaled(row(normals, 3 * k + 1), v)), scaled(row(normals, 3 * k + 2), 1.0 - u - v)
    )
    m = owners[k]
    n = dot(axis_row(turns, m, 0), n), dot(axis_row(turns, m, 1), n), dot(axis_row(turns, m, 2), n)
    sight = ray(camera, x, y)
    return surface_light(sun, shadows, sight, add_scaled(row(camera, 0), 1.0 / near, sight), n, row(colors, k))


@kernel
def axis_row(turns, m, i):
    """Row i of rotation m."""
    return turns[m, i, 0], turns[m, i, 1], turns[m, i, 2]


@kernel
def held_back(pane, x, y, nearest, opacity, edge):
    """The share of the light behind the point (x, y) that a pane absorbs: 0 outside it, or behind a nearer surface.

    pane: its four corners.
    """
    a, b, c, d = pane
    near, margin = half_pane(a, b, c, x, y)
    if margin < 0.0:
        near, margin = half_pane(c, d, a, x, y)
    if margin < 0.0 or near <= nearest:
        return 0.0
    return opacity + (1.0 - opacity) * _EDGE_HOLDS if margin < edge else opacity


@kernel
def half_pane(a, b, c, x, y):
    """The nearness of a pane's half a, b, c at (x, y), and its distance to two edges."""
    area = twice_area(a, b, c)
    if area == 0.0:
        return 0.0, -1.0
    u, v = weights(a, b, c, area, x, y)
    w = 1.0 - u - v
    inside = min(u * abs(area) / length(b, c), w * abs(area) / length(a, b))
    return u * a[2] + v * b[2] + w * c[2], inside if v >= 0.0 else -1.0


@kernel
def length(a, b):
    """The distance of two points of the raster."""
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]))
