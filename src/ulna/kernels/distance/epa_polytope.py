"""Grows a polytope of support points of the Minkowski difference of two cores.

A row of ``points`` is the difference w = p - q, then p. A row of ``faces`` is the indices of a face's corners, counter-clockwise
as seen from outside, its unit normal, and its offset from the origin.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import sqrt
from ulna.kernels.distance.gjk import difference
from ulna.kernels.spatial.vectors import add_scaled, cross, dot, minus, scaled

MAX_POINTS = 4096
POINT_WIDTH, FACE_WIDTH = 6, 7
_TETRAHEDRON = (0, 1, 2), (1, 0, 3), (2, 1, 3), (0, 2, 3)
_FLAT = 1e-13  # of the bodies' size: a thinner set has no volume


@routine
def farthest(cores, n, points, i):
    """Write the support point along n, and its p, to row i of the points. Returns its extent along n."""
    core_a, core_b, relative = cores
    w, p = difference(core_a, core_b, relative, (-n[0], -n[1], -n[2]))
    for k in range(3):
        points[i, k], points[i, 3 + k] = w[k], p[k]
    return dot(n, w)


@kernel
def point(points, i):
    """Point i of the set."""
    return points[i, 0], points[i, 1], points[i, 2]


@kernel
def extent(cores, points):
    """The size of the set: the sum of its widths along the three axes.

    The ends along the widest axis are written to rows 0 and 1.
    """
    size, widest = 0.0, -1.0
    for k in range(3):
        n = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
        i = 2 if k > 0 else 0  # rows for the ends under test
        width = farthest(cores, n, points, i) + farthest(cores, scaled(n, -1.0), points, i + 1)
        size += width
        if width > widest:
            widest = width
            for c in range(POINT_WIDTH):
                points[0, c], points[1, c] = points[i, c], points[i + 1, c]
    return size


@kernel
def first_polytope(cores, size, points, faces):
    """Make a tetrahedron of support points; whether the set is flat, and if so its normal.

    Two points are given. The third is the farthest from their line, the fourth the farthest from the plane of the three.
    """
    n = (1.0, 0.0, 0.0)
    if size <= 0.0:
        return True, n
    for found in (2, 3):
        d, e = minus(point(points, 1), point(points, 0)), minus(point(points, 2), point(points, 0))
        n = perpendicular(d) if found == 2 else unit_cross(d, e)
        width = farther_of_two(cores, n, points, found)
        if found == 2 and width <= _FLAT * size:
            n = unit_cross(d, n)
            width = farther_of_two(cores, n, points, found)
        if width <= _FLAT * size:
            return True, n
    if dot(n, minus(point(points, 3), point(points, 0))) > 0.0:  # seen from the fourth point the others run clockwise
        for k in range(POINT_WIDTH):
            points[1, k], points[2, k] = points[2, k], points[1, k]
    for f in range(4):
        i, j, k = _TETRAHEDRON[f]
        set_face(points, faces, f, i, j, k)
    return False, n


@kernel
def perpendicular(d):
    """A unit vector perpendicular to d: the cross product with the axis of d's smallest entry."""
    x, y, z = abs(d[0]), abs(d[1]), abs(d[2])
    by_x, by_y = x <= y and x <= z, y < x and y <= z
    return unit_cross(d, (1.0 if by_x else 0.0, 1.0 if by_y else 0.0, 0.0 if by_x or by_y else 1.0))


@kernel
def unit_cross(a, b):
    """The normalized cross product of two vectors."""
    n = cross(a, b)
    return scaled(n, 1.0 / sqrt(dot(n, n)))


@kernel
def farther_of_two(cores, n, points, i):
    """Write the set's point farthest from point 0 along n or -n to row i; its distance along n."""
    start = dot(n, point(points, 0))
    above = farthest(cores, n, points, i) - start
    below = farthest(cores, scaled(n, -1.0), points, i + 1) + start
    if below > above:
        for k in range(POINT_WIDTH):
            points[i, k] = points[i + 1, k]
    return max(above, below)


@routine
def set_face(points, faces, f, i, j, k):
    """Write face f with the corners i, j, k, counter-clockwise as seen from outside: corners, unit normal, offset."""
    p = point(points, i)
    n = cross(minus(point(points, j), p), minus(point(points, k), p))
    length = sqrt(dot(n, n))
    n = scaled(n, 1.0 / length) if length > 0.0 else (0.0, 0.0, 0.0)
    faces[f, 0], faces[f, 1], faces[f, 2] = i, j, k
    faces[f, 3], faces[f, 4], faces[f, 5] = n
    faces[f, 6] = dot(n, p) if length > 0.0 else 1e300  # collinear corners: never the lowest face


@kernel
def lowest_face(faces, n_faces):
    """The face whose plane has the minimum offset from the origin."""
    lowest = 0
    for f in range(1, n_faces):
        if faces[f, 6] < faces[lowest, 6]:
            lowest = f
    return lowest


@kernel
def remove_visible(points, w, faces, n_faces, edges, level):
    """Remove the faces visible from point w; the number of remaining faces, and of the hole's edges."""
    n_edges, f = 0, 0
    p = point(points, w)
    while f < n_faces:
        height = faces[f, 3] * p[0] + faces[f, 4] * p[1] + faces[f, 5] * p[2] - faces[f, 6]
        if height <= level:
            f += 1
            continue
        for k in range(3):
            n_edges = toggle_edge(edges, n_edges, faces[f, k], faces[f, (k + 1) % 3])
        n_faces -= 1
        for k in range(FACE_WIDTH):
            faces[f, k] = faces[n_faces, k]
    return n_faces, n_edges


@kernel
def toggle_edge(edges, n_edges, i, j):
    """Add an edge, or remove its reverse: an edge listed twice lies between two removed faces."""
    for k in range(n_edges):
        if edges[k, 0] == j and edges[k, 1] == i:
            edges[k, 0], edges[k, 1] = edges[n_edges - 1, 0], edges[n_edges - 1, 1]
            return n_edges - 1
    if n_edges < edges.shape[0]:
        edges[n_edges, 0], edges[n_edges, 1] = i, j
        n_edges += 1
    return n_edges


@routine
def nearest_of_surface(points, faces, n_faces):
    """The point of the polytope's surface nearest to the origin, and its point of A.

    Coplanar faces have equal offsets, but only one contains the nearest point, so every face is tested.
    """
    nearest, found, deepest = 1e300, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for f in range(n_faces):
        i, j, k = int(faces[f, 0]), int(faces[f, 1]), int(faces[f, 2])
        w, e, d = point(points, i), minus(point(points, j), point(points, i)), minus(point(points, k), point(points, i))
        n = cross(e, d)
        square = max(dot(n, n), 1e-300)
        x = min(max(dot(cross(d, w), n) / square, 0.0), 1.0)
        y = min(max(dot(cross(w, e), n) / square, 0.0), 1.0 - x)
        v = add_scaled(add_scaled(w, x, e), y, d)
        if dot(v, v) < nearest:
            nearest, found, z = dot(v, v), v, 1.0 - x - y
            deepest = add_scaled(add_scaled(scaled(source(points, i), z), x, source(points, j)), y, source(points, k))
    return found, deepest


@kernel
def source(points, i):
    """The point of A that belongs to point i of the set."""
    return points[i, 3], points[i, 4], points[i, 5]
