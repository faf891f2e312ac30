"""Finds the samples that a triangle covers on a raster.

If several triangles cover a sample, the triangle nearest to the camera counts, or nearest to the light.

A point of a raster has three numbers: x to the right [samples], y down [samples], and a nearness. The nearness is a linear
function of x and y on a triangle, and larger for nearer points. For a camera it is the inverse of the depth. For a light far away
it is the height towards the light. Sample (i, j) lies at x = j + 1/2, y = i + 1/2. The kernels compute with plain float64 numbers
and not with lanes, since most triangles cover only a few samples.

Source: Pineda, A parallel algorithm for polygon rasterization (SIGGRAPH 1988), for the edge functions; Burns and Hunt, The
visibility buffer (JCGT 2013), for keeping the triangle's number, and shading only what is seen in the end.
"""

import numpy as np

from ulna.engine.decorators import kernel


@kernel
def corners(points, triangles, k):
    """The three corners of triangle k."""
    return row(points, triangles[k, 0]), row(points, triangles[k, 1]), row(points, triangles[k, 2])


@kernel
def row(table, i):
    """The first three numbers of row i of a table."""
    return table[i, 0], table[i, 1], table[i, 2]


@kernel
def twice_area(a, b, c):
    """Twice the area that a triangle covers on the raster; negative if its corners go round the other way."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])


@kernel
def weights(a, b, c, area, x, y):
    """The place (x, y) as weights of the first two corners; with the third they sum to 1. Inside, none is negative."""
    u = ((b[0] - x) * (c[1] - y) - (c[0] - x) * (b[1] - y)) / area
    v = ((c[0] - x) * (a[1] - y) - (a[0] - x) * (c[1] - y)) / area
    return u, v


@kernel
def span(low, high, n):
    """The samples from the first to behind the last, of n, whose centers lie between two places."""
    low, high = max(low, 0.0), min(high, float(n))
    if not low < high:
        return 0, 0
    return int(np.ceil(low - 0.5)), int(np.floor(high - 0.5)) + 1


@kernel
def above_zero(value, slope, low, high):
    """The whole numbers j from low to below high at which value + j slope is not negative."""
    if slope > 0.0:
        return max(low, int(min(np.ceil(-value / slope), float(high)))), high
    if slope < 0.0:
        return low, min(high, int(max(np.floor(-value / slope), low - 1.0)) + 1)
    return (low, high) if value >= 0.0 else (low, low)
