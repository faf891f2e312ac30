"""Compiled loops over pixels that rasterize, shade and compose one picture."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ulna.engine.decorators import entry
from ulna.engine.lanes import sqrt
from ulna.engine.signatures import (
    INDEX_ROWS,
    INDICES,
    LIGHT,
    MATRICES,
    MATRIX,
    NEARNESS,
    NONE,
    NUMBERED,
    NUMBERS,
    PIXELS,
    SKIN,
    Group,
)
from ulna.kernels.render.raster import above_zero, corners, row, span, twice_area, weights
from ulna.kernels.render.shading import EDGE, held_back, sample_light, uniform
from ulna.kernels.spatial.se3 import constant_pose
from ulna.kernels.spatial.vectors import plus, scaled, transform


@entry((MATRIX, MATRIX, NEARNESS, LIGHT))
def lay_panes(points, paints, nearness, light):
    """Blend flat panes of four corners over the light of a picture, one after the other.

    1. For each pixel within a pane's bounds, take the mean opacity of the pane over the pixel's samples. A sample outside the
       pane, or behind a nearer surface, counts as 0. The opacity is higher along the edges.
    2. Blend the pixel's light with the pane's color by that opacity.

    Args:
        points: Raster coordinates of the corners, shape (4 n, 3), as in ``kernels.render.raster``; four in a row are a pane.
        paints: Red, green, blue (linear) and opacity of each pane, shape (n, 4).
        nearness: The nearness of the surfaces drawn before, shape (m * height, m * width).
        light: The light of the pixels, shape (height, width, 3); written to.
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
                            held += held_back((a, b, c, d), x + 0.5, y + 0.5, nearness[y, x], paints[k, 3], EDGE * m)
                    if held > 0.0:
                        part = held / (m * m)
                        for channel in range(3):
                            light[i, j, channel] += part * (paints[k, channel] - light[i, j, channel])


@entry((MATRIX, INDICES, MATRIX, MATRIX, MATRIX))
def place_points(points, frames, poses, view, placed):
    """Write the raster coordinates of points that move with frames.

    Args:
        points: The points in their frames, shape (n, 3).
        frames: The frame of each point, shape (n,).
        poses: The poses of the frames in the base, twelve numbers each, shape (n_frames, 12).
        view: Twelve numbers of the projection from the base to the raster, and a thirteenth, shape (1, 13). The thirteenth is 1
            for a camera, whose first two rows are divided by the third, the depth; it is 0 for a light far away.
        placed: The raster coordinates, shape (n, 3); written to. Behind a camera the nearness is zero.
    """
    for k in range(points.shape[0]):
        p = transform(constant_pose(poses, frames[k], 0.0), row(points, k))
        x, y, z = transform(constant_pose(view, 0, 0.0), p)
        if view[0, 12] > 0.0:
            z = 1.0 / z if z > 0.0 else 0.0
            x, y = x * z, y * z
        placed[k, 0], placed[k, 1], placed[k, 2] = x, y, z


@entry((MATRIX, INDEX_ROWS, NEARNESS, NUMBERED), (MATRIX, INDEX_ROWS, NEARNESS, NONE))
def draw_triangles(points, triangles, nearness, numbers):
    """Draw triangles into a depth buffer.

    1. Skip a triangle without area, or with a corner behind the eye.
    2. In each row of samples, find the samples inside: all three barycentric weights are nonnegative.
    3. Compute the nearness of the triangle at each of these. If it is the nearest, store it and the triangle's number.

    Args:
        points: Raster coordinates of the vertices, shape (n, 3).
        triangles: The vertices of each triangle, shape (m, 3).
        nearness: The nearness of the nearest surface, zero where there is none, shape (height, width); written to.
        numbers: The number of the nearest triangle, of the same shape, or None to store the nearness alone; written to.
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


class Raster(NamedTuple):
    """Triangles on a raster, and the depth buffer that they were drawn into."""

    points: NDArray[np.float64]
    """Raster coordinates of the vertices, shape (n_points, 3)."""
    triangles: NDArray[np.int64]
    """The vertices of each triangle, shape (n_triangles, 3)."""
    numbers: NDArray[np.int32]
    """The number of the triangle seen at each sample, shape (n * height, n * width)."""
    nearness: NDArray[np.float32]
    """The nearness of that triangle at the sample, of the same shape."""


class Lighting(NamedTuple):
    """The light of a picture. See ``kernels.render.illumination``."""

    sun: NDArray[np.float64]
    """The projection to the sun's raster, shape (3, 4)."""
    shadows: NDArray[np.float32]
    """The nearness on the sun's raster: the shadow map."""
    floor: NDArray[np.float64]
    """The height of the floor, its cell, and the lamp, shape (7,)."""


_RASTER, _LIGHTING = Group((MATRIX, INDEX_ROWS, NUMBERED, NEARNESS), Raster), Group((MATRIX, NEARNESS, NUMBERS), Lighting)


@entry((_RASTER, SKIN, MATRICES, MATRIX, _LIGHTING, LIGHT))
def shade_pixels(raster, skin, turns, camera, lighting, light):
    """Compute the light of every pixel.

    1. If all samples of a pixel show the same piece of surface, or the floor, take the light at the middle of the pixel.
    2. Otherwise take the mean of the light at its samples. So edges are smooth, and only pixels at edges cost more.

    Args:
        raster: A ``Raster``.
        skin: Four arrays of the triangles: the normals at their corners in the axes of their links, shape (3 n_triangles, 3);
            their linear colors, shape (n_triangles, 3); their emitted shares, 0 for none; their links.
        turns: The rotation of each link, shape (n_links, 3, 3).
        camera: The rays of the camera, shape (4, 3). See ``kernels.render.illumination``.
        lighting: A ``Lighting``.
        light: The light of the pixels, shape (height, width, 3); written to.
    """
    numbers = raster.numbers
    n = numbers.shape[0] // light.shape[0]
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            if uniform(numbers, raster.nearness, skin, n, n * i, n * j):
                k, x, y = numbers[n * i + n // 2, n * j + n // 2], n * j + n // 2 + 0.5, n * i + n // 2 + 0.5
                total = sample_light(raster, skin, turns, camera, lighting, k, (x, y))
            else:
                total = 0.0, 0.0, 0.0
                for y in range(n * i, n * i + n):
                    for x in range(n * j, n * j + n):
                        k = numbers[y, x]
                        one = sample_light(raster, skin, turns, camera, lighting, k, (x + 0.5, y + 0.5))
                        total = plus(total, (min(one[0], 1.0), min(one[1], 1.0), min(one[2], 1.0)))
                total = scaled(total, 1.0 / (n * n))
            light[i, j, 0], light[i, j, 1], light[i, j, 2] = total


@entry((LIGHT, PIXELS))
def encode(light, pixels):
    """Convert linear light to screen values, 0 to 255, by a square root.

    The square root is close to the response curve of a screen.

    Args:
        light: The linear light, shape (height, width, 3).
        pixels: The screen values, uint8, of the same shape; written to.
    """
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            for c in range(3):
                pixels[i, j, c] = int(255.0 * sqrt(min(max(light[i, j, c], 0.0), 1.0)) + 0.5)
