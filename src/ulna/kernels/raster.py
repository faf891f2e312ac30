"""Triangles on a raster: which of them is nearest behind each sample, seen by a camera or by a light.

A point of a raster has three numbers: x to the right and y down [samples], and a nearness that is linear on the raster and larger
for what is nearer: of a camera the inverse of the depth, of a light far away the height towards it. Sample (i, j) lies at
x = j + 1/2, y = i + 1/2. Plain float64 and no lanes: most triangles cover but a few samples.

Source: Pineda, A parallel algorithm for polygon rasterization (SIGGRAPH 1988), for the edge functions; Burns and Hunt, The
visibility buffer (JCGT 2013), for keeping the triangle's number, and shading only what is seen in the end.
"""

import numpy as np

from ulna.kernels.compile import entry, kernel
from ulna.kernels.kinds import INDEX_ROWS, INDICES, MATRIX, NEARNESS, NONE, NUMBERED
from ulna.kernels.se3 import constant_pose
from ulna.kernels.vectors import place

NOTHING = -1  # the number of no triangle


@entry((MATRIX, INDICES, MATRIX, MATRIX, MATRIX))
def place_points(points, frames, poses, view, placed):
    """Write where points that move with frames stand on a raster.

    Args:
        points: In their frames, shape (n, 3).
        frames: The frame of each, shape (n,).
        poses: Of the frames in the base, twelve numbers each, shape (n_frames, 12).
        view: The map from the base to the raster, twelve numbers, and a thirteenth, shape (1, 13): 1 for a camera, of which the
            third number is the depth, by which the others are divided; 0 for a light far away.
        placed: Shape (n, 3); written to. Behind a camera the nearness is zero.
    """
    for k in range(points.shape[0]):
        p = place(constant_pose(poses, frames[k], 0.0), row(points, k))
        x, y, z = place(constant_pose(view, 0, 0.0), p)
        if view[0, 12] > 0.0:
            z = 1.0 / z if z > 0.0 else 0.0
            x, y = x * z, y * z
        placed[k, 0], placed[k, 1], placed[k, 2] = x, y, z


@entry((MATRIX, INDEX_ROWS, NEARNESS, NUMBERED), (MATRIX, INDEX_ROWS, NEARNESS, NONE))
def draw_triangles(points, triangles, nearness, numbers):
    """Enter triangles into a raster.

    1. Leave out a triangle with a corner behind the eye, or of no area.
    2. In each row of samples those between its edges: where none of the three weights of its corners is negative.
    3. There its nearness; if none nearer was entered, enter it and the triangle's number.

    Args:
        points: Raster coordinates of the vertices, shape (n, 3).
        triangles: Their vertices, shape (m, 3).
        nearness: What was entered so far, zero where nothing, shape (height, width); written to.
        numbers: The triangle that was nearest, of the same shape, or None if only the nearness is asked for; written to.
    """
    for k in range(triangles.shape[0]):
        a, b, c = corners(points, triangles, k)
        area = twice_area(a, b, c)
        if a[2] > 0.0 and b[2] > 0.0 and c[2] > 0.0 and area != 0.0:
            left, right = span(min(a[0], b[0], c[0]), max(a[0], b[0], c[0]), nearness.shape[1])
            top, bottom = span(min(a[1], b[1], c[1]), max(a[1], b[1], c[1]), nearness.shape[0])
            slope_u, slope_v = (b[1] - c[1]) / area, (c[1] - a[1]) / area
            for i in range(top, bottom):
                u0, v0 = weights(a, b, c, area, 0.5, i + 0.5)
                low, high = above_zero(u0, slope_u, left, right)
                low, high = above_zero(v0, slope_v, low, high)
                low, high = above_zero(1.0 - u0 - v0, -slope_u - slope_v, low, high)
                for j in range(low, high):
                    near = c[2] + (u0 + j * slope_u) * (a[2] - c[2]) + (v0 + j * slope_v) * (b[2] - c[2])
                    if near > nearness[i, j]:
                        nearness[i, j] = near
                        if numbers is not None:
                            numbers[i, j] = k


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
    """The samples from the first to behind the last, of n, whose centres lie between two places."""
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
