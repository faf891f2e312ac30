"""From the triangle behind each sample to the light of each pixel, and from light to the colours of a screen."""

from ulna.kernels.compile import entry, kernel, routine
from ulna.kernels.kinds import INDEX_ROWS, LIGHT, MATRICES, MATRIX, NEARNESS, NUMBERED, NUMBERS, PIXELS, SKIN
from ulna.kernels.lanes import sqrt
from ulna.kernels.light import floor_light, ray, surface_light
from ulna.kernels.raster import NOTHING, corners, row, twice_area, weights
from ulna.kernels.vectors import dot, plus, step, times

_SAME_DEPTH, _SAME_TURN = 0.02, 0.95  # two samples within these show the same piece of surface


@entry((NUMBERED, NEARNESS, MATRIX, INDEX_ROWS, SKIN, MATRICES, MATRIX, MATRIX, NEARNESS, NUMBERS, LIGHT))
def shade_pixels(numbers, nearness, points, triangles, skin, turns, camera, sun, shadows, floor, light):
    """Write the light of every pixel.

    1. Where all samples of a pixel show the same piece of surface, or the floor, the light of its middle.
    2. Elsewhere the mean of the light of each: so edges are smooth, and only they cost more.

    Args:
        numbers: The triangle behind each sample, shape (n * height, n * width).
        nearness: Its nearness there.
        points: Raster coordinates of the vertices, shape (n_points, 3).
        triangles: Shape (n_triangles, 3).
        skin: Four arrays of the triangles: the normals of their corners in the axes of their link, shape (3 n_triangles, 3);
            linear colours, shape (n_triangles, 3); how much of it each shines by itself, 0 for none; their links.
        turns: The rotation of each link, shape (n_links, 3, 3).
        camera: Shape (4, 3). See ``kernels.light``; as the sun, its shadows and the floor.
        sun: Shape (3, 4).
        shadows: Nearness on the sun's raster.
        floor: Shape (7,).
        light: Shape (height, width, 3); written to.
    """
    n = numbers.shape[0] // light.shape[0]
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            if uniform(numbers, nearness, skin, n, n * i, n * j):
                k, x, y = numbers[n * i + n // 2, n * j + n // 2], n * j + n // 2 + 0.5, n * i + n // 2 + 0.5
                total = sample_light(points, triangles, skin, turns, camera, sun, shadows, floor, k, x, y)
            else:
                total = 0.0, 0.0, 0.0
                for y in range(n * i, n * i + n):
                    for x in range(n * j, n * j + n):
                        k = numbers[y, x]
                        one = sample_light(points, triangles, skin, turns, camera, sun, shadows, floor, k, x + 0.5, y + 0.5)
                        total = plus(total, (min(one[0], 1.0), min(one[1], 1.0), min(one[2], 1.0)))
                total = times(total, 1.0 / (n * n))
            light[i, j, 0], light[i, j, 1], light[i, j, 2] = total


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
def sample_light(points, triangles, skin, turns, camera, sun, shadows, floor, k, x, y):
    """The light behind the place (x, y) of the raster, where triangle k is seen, or none."""
    if k == NOTHING:
        return floor_light(camera, sun, shadows, floor, x, y)
    normals, colors, glow, owners = skin
    if glow[k] > 0.0:
        return times(row(colors, k), glow[k])
    a, b, c = corners(points, triangles, k)
    u, v = weights(a, b, c, twice_area(a, b, c), x, y)
    near = c[2] + u * (a[2] - c[2]) + v * (b[2] - c[2])
    u, v = u * a[2] / near, v * b[2] / near  # the weights in space
    n = plus(plus(times(row(normals, 3 * k), u), times(row(normals, 3 * k + 1), v)), times(row(normals, 3 * k + 2), 1.0 - u - v))
    m = owners[k]
    n = dot(axis_row(turns, m, 0), n), dot(axis_row(turns, m, 1), n), dot(axis_row(turns, m, 2), n)
    sight = ray(camera, x, y)
    return surface_light(sun, shadows, sight, step(row(camera, 0), 1.0 / near, sight), n, row(colors, k))


@kernel
def axis_row(turns, m, i):
    """Row i of rotation m."""
    return turns[m, i, 0], turns[m, i, 1], turns[m, i, 2]


@entry((LIGHT, PIXELS))
def encode(light, pixels):
    """Light as the numbers of a screen, 0 to 255, whose square it is: a screen's curve is near that.

    Args:
        light: Linear, shape (height, width, 3).
        pixels: Of the same shape, uint8; written to.
    """
    for i in range(light.shape[0]):
        for j in range(light.shape[1]):
            for c in range(3):
                pixels[i, j, c] = int(255.0 * sqrt(min(max(light[i, j, c], 0.0), 1.0)) + 0.5)
