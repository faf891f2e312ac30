"""Computes the penetration depth of two convex cores, by the expanding polytope algorithm (EPA).

It takes one pair of plain numbers. The Minkowski difference is the set of all p - q for points p of A and q of B. It is convex
and contains the origin. The depth is the distance from the origin to its surface. The outward normal there is the direction of
the shortest translation that separates the two.

1. Begin with a tetrahedron of support points, a polytope inside the Minkowski difference. It need not contain the origin.
2. Take the face whose plane has the minimum offset from the origin. This offset is a lower bound of the depth.
3. The support point along the normal of that face gives an upper bound of the depth. If the bounds are equal, this is the depth.
4. If not, add the point to the polytope: remove the faces that see it, and connect their boundary to it. Repeat from 2.
5. At the end the nearest point of the surface must pass step 3 too. It may be on another face of almost the same offset. This
   point is a weighted sum of corners. The same weights, applied to the points p and q of these corners, give the witness points.

For polytopes the algorithm ends with the exact depth after finitely many steps. Exceptions are those that need more than
MAX_POINTS points, such as round hulls of many thousand vertices. For cylinders the bounds converge. If the point budget runs out,
the best upper bound is returned. No result is less than the depth. A flat Minkowski difference (of two flat cores in one plane)
has depth zero along its own normal.

Source: van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001.
"""

import numpy as np

from ulna.engine.decorators import kernel, shared_routine
from ulna.engine.lanes import lane_count, lane_of, sqrt, with_lane
from ulna.kernels.distance.body_records import Core
from ulna.kernels.distance.box_sat import relative_pose
from ulna.kernels.distance.epa_polytope import (
    FACE_WIDTH,
    MAX_POINTS,
    POINT_WIDTH,
    extent,
    farthest,
    first_polytope,
    lowest_face,
    nearest_of_surface,
    perpendicular,
    remove_visible,
    set_face,
)
from ulna.kernels.distance.gjk import nearest_cores
from ulna.kernels.layout import CYLINDER
from ulna.kernels.spatial.elementary import sincos
from ulna.kernels.spatial.vectors import (
    add_scaled,
    cross,
    dot,
    origin,
    rotate,
    scaled,
    transform,
    transform_inverse,
    x_axis,
    y_axis,
    z_axis,
)

FACES, EDGES = 2, 3  # bound on a polytope's faces and edges per point: no closed surface of triangles has more
SCRATCH = (MAX_POINTS, POINT_WIDTH), (FACES * MAX_POINTS, FACE_WIDTH), (EDGES * MAX_POINTS, 2)  # shapes for any two cores
_EXACT = 1e-10  # of the bodies' size: the bounds have converged; much smaller faces have no usable normals
_TOUCHING = 1e-9  # of the bodies' size: a surface point this near to the origin gives no direction
_CLEARANCE = 1e-3  # of the bodies' size
_ROUNDS = 8
_OF_BOX = 8  # corners
_CURVED = 160  # points of a polytope inside a curved set, which could be refined without end
_DIRECTIONS, _SECTIONS, _GOLDEN = 64, 40, 0.6180339887498949
_LEVEL = 1e-13  # of the bodies' size: a point at most this far above a face does not see it


@kernel
def points_needed(n, m):
    """The number of points to allocate, for hulls with n vertices in all, and the others' hulls with m.

    A Minkowski difference has at most as many corners as the product of the corner counts of its two cores; a box has eight.
    """
    return min(MAX_POINTS, max(_CURVED, max(n, _OF_BOX) * max(n, m, _OF_BOX)))


@kernel
def with_penetration(a, core_a, b, core_b, contact, inside, scratch):
    """Replace the contact by the penetration in the lanes where the cores overlap, one lane after the other.

    The distance there is minus the depth.
    """
    distance, p, q, n = contact
    for lane in range(lane_count(distance)):
        if lane_of(inside, lane) != 0.0:
            x, y = pose_of(a, lane), pose_of(b, lane)
            common, one, other = transform_inverse(x, vector_of(p, lane)), core_of(core_a, lane), core_of(core_b, lane)
            depth, deepest, way = core_depth(one, other, relative_pose(x, y), common, scratch)
            deepest, way = transform(x, deepest), rotate(x, way)
            distance, n = with_lane(distance, lane, -depth), vector_with(n, lane, way)
            p, q = vector_with(p, lane, deepest), vector_with(q, lane, add_scaled(deepest, -depth, way))
    return distance, p, q, n


@kernel
def core_of(core, lane):
    """A core in one lane, as plain numbers."""
    return Core(core.kind, vector_of(core.half, lane), core.vertices)


@kernel
def vector_of(v, lane):
    """A vector in one lane, as plain numbers."""
    return lane_of(v[0], lane), lane_of(v[1], lane), lane_of(v[2], lane)


@kernel
def vector_with(v, lane, w):
    """A vector with one lane replaced by the vector w of plain numbers."""
    return with_lane(v[0], lane, w[0]), with_lane(v[1], lane, w[1]), with_lane(v[2], lane, w[2])


@kernel
def pose_of(a, lane):
    """A pose in one lane, as plain numbers."""
    x, y, z, t = vector_of(x_axis(a), lane), vector_of(y_axis(a), lane), vector_of(z_axis(a), lane), vector_of(origin(a), lane)
    return x[0], y[0], z[0], t[0], x[1], y[1], z[1], t[1], x[2], y[2], z[2], t[2]


@shared_routine
def core_depth(core_a, core_b, relative, common_point, scratch):
    """The depth, A's point deepest in B, and the normal from A to B, in the frame of A.

    relative: R_a_b, t_a_b. common_point: A point of both, returned if the Minkowski difference has no volume.
    """
    cores, (points, faces, edges) = (core_a, core_b, relative), scratch
    size = extent(cores, points)
    flat, normal = first_polytope(cores, size, points, faces)
    if flat:
        return 0.0, common_point, normal
    n_points, n_faces, depth = 4, 4, 1e300
    most = _CURVED if (core_a.kind == CYLINDER) | (core_b.kind == CYLINDER) else points.shape[0]
    while n_points < most:
        face = lowest_face(faces, n_faces)
        n = (faces[face, 3], faces[face, 4], faces[face, 5])
        height = farthest(cores, n, points, n_points)
        if height < depth:
            depth, normal = height, n
        if depth - faces[face, 6] <= _EXACT * size:
            w, p = nearest_of_surface(points, faces, n_faces)
            distance = sqrt(dot(w, w))
            if distance <= _TOUCHING * size:
                return max(depth, 0.0), p, normal
            n = scaled(w, 1.0 / distance)
            if farthest(cores, n, points, n_points) - distance <= _EXACT * size:
                return distance, p, n
        n_faces, n_edges = remove_visible(points, n_points, faces, n_faces, edges, _LEVEL * size)
        if n_edges == 0 or n_faces + n_edges > faces.shape[0]:
            break
        for k in range(n_edges):
            set_face(points, faces, n_faces + k, int(edges[k, 0]), int(edges[k, 1]), n_points)
        n_faces, n_points = n_faces + n_edges, n_points + 1
    return refined_depth(cores, depth, normal, size, points)


@kernel
def depth_around_axes(cores, depth, n, points):
    """The minimum bound and its normal, among the given ones and the normals across each cylinder's axis.

    If two bodies of revolution share an axis, or nearly so, the depth is almost equal in all directions around it. A polytope is
    never fine enough there, but a search over the circle of directions is.
    """
    core_a, core_b, (r, _) = cores
    if core_a.kind == CYLINDER:
        depth, n = depth_around_axis(cores, (0.0, 0.0, 1.0), depth, n, points)
    if core_b.kind == CYLINDER:
        depth, n = depth_around_axis(cores, (r[0][2], r[1][2], r[2][2]), depth, n, points)
    return depth, n


@kernel
def depth_around_axis(cores, z, depth, n, points):
    """``depth_around_axes`` for the axis z.

    Takes the lowest of many directions, then a golden-section search of the arc about it (Kiefer, Proc. AMS 1953).
    """
    u = perpendicular(z)
    v = cross(z, u)
    best, lowest = 0.0, 1e300
    for k in range(_DIRECTIONS):
        angle = 2.0 * np.pi * k / _DIRECTIONS
        height = farthest(cores, point_on_circle(u, v, angle), points, 0)
        if height < lowest:
            best, lowest = angle, height
    low, high = best - 2.0 * np.pi / _DIRECTIONS, best + 2.0 * np.pi / _DIRECTIONS
    for _ in range(_SECTIONS):
        first, second = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        if farthest(cores, point_on_circle(u, v, first), points, 0) < farthest(cores, point_on_circle(u, v, second), points, 0):
            high = second
        else:
            low = first
    found = point_on_circle(u, v, 0.5 * (low + high))
    height = farthest(cores, found, points, 0)
    if height < depth:
        return height, found
    return depth, n


@kernel
def point_on_circle(u, v, angle):
    """The unit vector at an angle from u towards v."""
    sine, cosine = sincos(angle)
    return add_scaled(scaled(u, cosine), sine, v)


@kernel
def refined_depth(cores, depth, n, size, points):
    """Refine an upper bound of the depth and its normal: the depth, the point of A and the normal.

    B is moved out by the depth and a small clearance. The normal of the nearest points is then closer to the normal of minimum
    depth. It replaces the old one as long as it lowers the bound. These points, moved back, are the witness points.
    """
    core_a, core_b, (r, t) = cores
    depth, n = depth_around_axes(cores, depth, n, points)
    a = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    p = (0.0, 0.0, 0.0)
    for _ in range(_ROUNDS):
        at = add_scaled(t, max(depth, 0.0) + _CLEARANCE * size, n)
        b = (*r[0], at[0], *r[1], at[1], *r[2], at[2])
        _, _, p, _, nearest, _ = nearest_cores(a, core_a, b, core_b, -1.0)
        height = farthest(cores, nearest, points, 0)
        if height >= depth:
            break
        depth, n = height, nearest
    return max(depth, 0.0), p, n
