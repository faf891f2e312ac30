"""How deep two convex cores overlap: the expanding polytope algorithm, for one pair of plain numbers.

The differences p - q of points of A and B form a convex set that holds the origin; the depth is the distance from the origin
to its surface, and the outward normal there is the shortest way to part the two (van den Bergen, Proximity Queries and
Penetration Depth Computation on 3D Game Objects, GDC 2001).

1. A tetrahedron of support points is the first polytope within the set. It need not hold the origin.
2. Of its faces take the one whose plane lies least far out, the origin being in or out. Its offset bounds the depth from below.
3. The set's farthest point along that face's normal bounds the depth from above. Where the bounds meet, that is the depth.
4. Else the point joins the polytope: the faces that see it go, and their rim is joined to it. Go on with 2.

5. At the end the surface's nearest point, which may lie on another face about as low, must fulfil 3 as well: it is a sum of
   corners, and the sums of the points p and q that belong to these are the witness points.

For polytopes this ends with the exact depth after finitely many steps; for cylinders the bounds close in on it. Should the
points not suffice, as where all ways out across an axis are equally long, the least upper bound found is the answer.
A set without volume (of two flat cores in one plane) has depth zero along its own normal.
"""

from ulna.kernels.box_box import relative_pose
from ulna.kernels.compile import kernel, routine
from ulna.kernels.gjk import difference, nearest_cores
from ulna.kernels.lanes import lane_count, lane_of, sqrt, with_lane
from ulna.kernels.vectors import axis, cross, dot, minus, origin, place, seen_from, step, times, turn

MAX_POINTS, MAX_FACES, MAX_EDGES = 160, 320, 320
POINT_WIDTH, FACE_WIDTH = 6, 7
_TETRAHEDRON = (0, 1, 2), (1, 0, 3), (2, 1, 3), (0, 2, 3)
SCRATCH = (MAX_POINTS, POINT_WIDTH), (MAX_FACES, FACE_WIDTH), (MAX_EDGES, 2)  # shapes: points, faces, edges
_EXACT = 1e-10  # of the bodies' size: bounds that near have met; faces much smaller have no normals to go by
_TOUCHING = 1e-9  # of the bodies' size: a surface point so near to the origin gives no direction
_CLEARANCE = 1e-3  # of the bodies' size
_ROUNDS = 8
_FLAT = 1e-13  # of the bodies' size: a set so thin has no volume
_LEVEL = 1e-13  # of the bodies' size: a point no higher than this above a face does not see it


@kernel
def deepened(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, answer, inside, scratch):
    """The answer with the depth in place of zero in the lanes where the cores overlap, one lane after the other."""
    distance, p, q, n = answer
    for lane in range(lane_count(distance)):
        if lane_of(inside, lane) != 0.0:
            x, y = pose_of(a, lane), pose_of(b, lane)
            depth, deepest, way = core_depth(
                kind_a, vector_of(h, lane), vertices_a, kind_b, vector_of(g, lane), vertices_b, relative_pose(x, y),
                seen_from(x, vector_of(p, lane)), scratch[0], scratch[1], scratch[2],
            )  # fmt: skip
            deepest, way = place(x, deepest), turn(x, way)
            distance, n = with_lane(distance, lane, -depth), vector_with(n, lane, way)
            p, q = vector_with(p, lane, deepest), vector_with(q, lane, step(deepest, -depth, way))
    return distance, p, q, n


@kernel
def vector_of(v, lane):
    """A vector of one lane."""
    return lane_of(v[0], lane), lane_of(v[1], lane), lane_of(v[2], lane)


@kernel
def vector_with(v, lane, w):
    """A vector with the vector w of plain numbers in one lane."""
    return with_lane(v[0], lane, w[0]), with_lane(v[1], lane, w[1]), with_lane(v[2], lane, w[2])


@kernel
def pose_of(a, lane):
    """A pose of one lane."""
    x, y, z, t = vector_of(axis(a, 0), lane), vector_of(axis(a, 1), lane), vector_of(axis(a, 2), lane), vector_of(origin(a), lane)
    return x[0], y[0], z[0], t[0], x[1], y[1], z[1], t[1], x[2], y[2], z[2], t[2]


@routine
def core_depth(kind_a, h, vertices_a, kind_b, g, vertices_b, relative, meeting, points, faces, edges):
    """The depth, the point of A that lies deepest in B, and the normal from A to B, in the frame of A.

    relative is R_a_b, t_a_b. ``meeting`` is a point of both, the answer where the set has no volume.
    """
    r, t = relative
    body = (kind_a, h, vertices_a, kind_b, g, vertices_b, r, t)
    size = extent(body, points)
    flat, normal = first_polytope(body, size, points, faces)
    if flat:
        return 0.0, meeting, normal
    n_points, n_faces, depth = 4, 4, 1e300
    while n_points < MAX_POINTS:
        face = lowest_face(faces, n_faces)
        n = (faces[face, 3], faces[face, 4], faces[face, 5])
        height = farthest(body, n, points, n_points)
        if height < depth:
            depth, normal = height, n
        if depth - faces[face, 6] <= _EXACT * size:
            w, p = nearest_of_surface(points, faces, n_faces)
            distance = sqrt(dot(w, w))
            if distance <= _TOUCHING * size:
                return max(depth, 0.0), p, normal
            n = times(w, 1.0 / distance)
            if farthest(body, n, points, n_points) - distance <= _EXACT * size:
                return distance, p, n
        n_faces, n_edges = remove_seen(points, n_points, faces, n_faces, edges, _LEVEL * size)
        if n_edges == 0 or n_faces + n_edges > MAX_FACES:
            break
        for k in range(n_edges):
            set_face(points, faces, n_faces + k, int(edges[k, 0]), int(edges[k, 1]), n_points)
        n_faces, n_points = n_faces + n_edges, n_points + 1
    return polished(body, depth, normal, size, points)


@routine
def polished(body, depth, n, size, points):
    """The depth, the point of A and the normal, from an upper bound of the depth and its normal.

    Once B has gone out by the depth and a little more, the nearest points have a normal nearer to the one sought. It is taken as
    long as it lowers the bound; in the end these points, moved back, are the witness points.
    """
    kind_a, h, vertices_a, kind_b, g, vertices_b, r, t = body
    a = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    p = (0.0, 0.0, 0.0)
    for _ in range(_ROUNDS):
        at = step(t, max(depth, 0.0) + _CLEARANCE * size, n)
        b = (*r[0], at[0], *r[1], at[1], *r[2], at[2])
        _, _, p, _, nearest, _ = nearest_cores(kind_a, a, h, vertices_a, kind_b, b, g, vertices_b, -1.0)
        height = farthest(body, nearest, points, 0)
        if height >= depth:
            break
        depth, n = height, nearest
    return max(depth, 0.0), p, n


@routine
def farthest(body, n, points, i):
    """How far the set reaches along n; its farthest point there, and that point's p, are put in place i of the points."""
    kind_a, h, vertices_a, kind_b, g, vertices_b, r, t = body
    w, p = difference(kind_a, h, vertices_a, kind_b, g, vertices_b, r, t, (-n[0], -n[1], -n[2]))
    for k in range(3):
        points[i, k], points[i, 3 + k] = w[k], p[k]
    return dot(n, w)


@kernel
def point(points, i):
    """Point i of the set."""
    return points[i, 0], points[i, 1], points[i, 2]


@kernel
def extent(body, points):
    """The size of the set: its widths along the three axes, together. The ends along the widest stand first in the points."""
    size, widest = 0.0, -1.0
    for k in range(3):
        n = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
        i = 2 if k > 0 else 0  # where the ends are tried
        width = farthest(body, n, points, i) + farthest(body, times(n, -1.0), points, i + 1)
        size += width
        if width > widest:
            widest = width
            for c in range(POINT_WIDTH):
                points[0, c], points[1, c] = points[i, c], points[i + 1, c]
    return size


@kernel
def first_polytope(body, size, points, faces):
    """Make a tetrahedron of support points; or say that the set is flat, and along which normal.

    Two points are there; the farthest from their line is the third, and the farthest from the plane of three the fourth.
    """
    n = (1.0, 0.0, 0.0)
    if size <= 0.0:
        return True, n
    for found in (2, 3):
        d, e = minus(point(points, 1), point(points, 0)), minus(point(points, 2), point(points, 0))
        n = across(d) if found == 2 else unit_cross(d, e)
        width = farther_of_two(body, n, points, found)
        if found == 2 and width <= _FLAT * size:
            n = unit_cross(d, n)
            width = farther_of_two(body, n, points, found)
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
def across(d):
    """A unit vector perpendicular to d: its product with the axis along which d reaches least."""
    x, y, z = abs(d[0]), abs(d[1]), abs(d[2])
    by_x, by_y = x <= y and x <= z, y < x and y <= z
    return unit_cross(d, (1.0 if by_x else 0.0, 1.0 if by_y else 0.0, 0.0 if by_x or by_y else 1.0))


@kernel
def unit_cross(a, b):
    """The cross product of two vectors, of length one."""
    n = cross(a, b)
    return times(n, 1.0 / sqrt(dot(n, n)))


@kernel
def farther_of_two(body, n, points, i):
    """Put the point of the set that is farthest from point 0 along n or -n in place i; how far it is."""
    start = dot(n, point(points, 0))
    above = farthest(body, n, points, i) - start
    below = farthest(body, times(n, -1.0), points, i + 1) + start
    if below > above:
        for k in range(POINT_WIDTH):
            points[i, k] = points[i + 1, k]
    return max(above, below)


@routine
def set_face(points, faces, f, i, j, k):
    """Write face f with the corners i, j, k, counter-clockwise seen from without: corners, unit normal, offset."""
    p = point(points, i)
    n = cross(minus(point(points, j), p), minus(point(points, k), p))
    length = sqrt(dot(n, n))
    n = times(n, 1.0 / length) if length > 0.0 else (0.0, 0.0, 0.0)
    faces[f, 0], faces[f, 1], faces[f, 2] = i, j, k
    faces[f, 3], faces[f, 4], faces[f, 5] = n
    faces[f, 6] = dot(n, p) if length > 0.0 else 1e300  # corners in one line: no face to leave by


@kernel
def lowest_face(faces, n_faces):
    """The face whose plane lies least far out."""
    lowest = 0
    for f in range(1, n_faces):
        if faces[f, 6] < faces[lowest, 6]:
            lowest = f
    return lowest


@kernel
def remove_seen(points, w, faces, n_faces, edges, level):
    """Take away the faces that point w sees from above; how many faces are left, and how many edges their hole has."""
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
    """Add an edge, or take it away with its reverse where that stands already: it lies between two faces that went."""
    for k in range(n_edges):
        if edges[k, 0] == j and edges[k, 1] == i:
            edges[k, 0], edges[k, 1] = edges[n_edges - 1, 0], edges[n_edges - 1, 1]
            return n_edges - 1
    if n_edges < MAX_EDGES:
        edges[n_edges, 0], edges[n_edges, 1] = i, j
        n_edges += 1
    return n_edges


@routine
def nearest_of_surface(points, faces, n_faces):
    """The point of the polytope's surface nearest to the origin, and the point of A that belongs to it.

    Faces in one plane have one offset, and the nearest point lies in one of them only: so each is asked.
    """
    nearest, found, deepest = 1e300, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for f in range(n_faces):
        i, j, k = int(faces[f, 0]), int(faces[f, 1]), int(faces[f, 2])
        w, e, d = point(points, i), minus(point(points, j), point(points, i)), minus(point(points, k), point(points, i))
        n = cross(e, d)
        square = max(dot(n, n), 1e-300)
        x = min(max(dot(cross(d, w), n) / square, 0.0), 1.0)
        y = min(max(dot(cross(w, e), n) / square, 0.0), 1.0 - x)
        v = step(step(w, x, e), y, d)
        if dot(v, v) < nearest:
            nearest, found, z = dot(v, v), v, 1.0 - x - y
            deepest = step(step(times(source(points, i), z), x, source(points, j)), y, source(points, k))
    return found, deepest


@kernel
def source(points, i):
    """The point of A that belongs to point i of the set."""
    return points[i, 3], points[i, 4], points[i, 5]
