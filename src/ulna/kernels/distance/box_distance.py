"""Computes the exact signed distance of two oriented boxes, with witness points and normal.

For separate boxes, the pairs of nearest points form a convex set. Let the pair (p, q) be an extreme point of this set. Let F and
G be the smallest faces, edges or corners of the boxes that contain p and q. F and G share no direction. Otherwise both points
could move along it, forwards and backwards, and stay a nearest pair. F and G are also perpendicular to the line through p and q.
So p or q is a corner of its box, or F and G are edges that are not parallel. In the second case F and G are the outermost edges
of their boxes along their common perpendicular. The distance is therefore the minimum over 25 pairs of points: 16 corners, each
with the nearest point of the other box, and one pair of edges for each of the 9 pairs of edge directions. Every candidate is a
pair of points of the boxes, so no candidate is nearer than the distance.

Overlapping boxes are first moved apart along the axis of minimum overlap (``box_sat``). There they touch, and the same search
finds the points. Boxes that touch (``CONTACT``) have distance zero and the normal of that axis, since the difference of such near
points is rounding. Extents of zero are allowed.
"""

import numpy as np

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, splat, sqrt, where
from ulna.kernels.distance.box_sat import boxes_overlap, columns, point_in_a, relative_pose, widest_gap
from ulna.kernels.spatial.elementary import clamp, maximum, minimum
from ulna.kernels.spatial.vectors import (
    add_scaled,
    chosen,
    cross,
    dot,
    minus,
    origin,
    plus,
    rotate,
    rotate_inverse,
    scaled,
    transform,
    transposed_times,
    x_axis,
    y_axis,
    z_axis,
)

# A tilt [rad] that decides which of two level edges is outermost, as in boxes with parallel faces. All edges use the same tilt,
# so the decisions are consistent with one pose. It only selects the points to compare.
_TILT = 0.6e-12, -0.36e-12, 0.71e-12


@kernel
def box_pair(a, h, b, g):
    """The signed distance of two boxes [m], p_a, p_b, and the normal from a to b.

    Points and normal are in the poses' reference frame.
    """
    gap, direction, near = separating_axis(a, h, b, g)
    r, t = relative_pose(a, b)
    n = rotate_inverse(a, direction)
    square, p, q = nearest_points(r, add_scaled(t, where(near, -gap, 0.0), n), h, g)
    # A clamp turns NaN into a number, so NaN is tested for first.
    numbers = dot(t, t) + dot(r[0], r[0]) + dot(r[1], r[1]) + dot(r[2], r[2]) >= 0.0
    distance = where(numbers, sqrt(square), np.nan)
    normal = chosen(near, n, scaled(minus(q, p), 1.0 / where(near, 1.0, distance)))
    signed = where(near, minimum(gap, 0.0), distance)
    return signed, transform(a, p), transform(a, chosen(near, add_scaled(p, signed, n), q)), rotate(a, normal)


@kernel
def separating_axis(a, h, b, g):
    """The widest gap [m], its axis from a to b, and the lanes where the boxes overlap or touch.

    Gap and axis are zero where the boxes are apart. Most pairs are far apart, and the first test, without square roots, finds
    this.
    """
    near = boxes_overlap(a, h, b, g)
    zero = splat(0.0, a[0])
    if not any_lane(near):
        return zero, (zero, zero, zero), near
    gap, index = widest_gap(a, h, b, g)
    n = axis_from(a, b, index)
    return where(near, gap, 0.0), chosen(near, n, (zero, zero, zero)), near


@kernel
def axis_from(a, b, index):
    """The unit vector of one of the fifteen axes of ``widest_gap``, pointing from box a to box b."""
    of_a, of_b = index < 2.5, index < 5.5
    i = where(index > 11.5, 2.0, where(index > 8.5, 1.0, 0.0))
    j = index - 6.0 - 3.0 * i
    u, v = pose_axis(a, where(of_b, index, i)), pose_axis(b, where(of_b, index - 3.0, j))
    n = chosen(of_a, u, chosen(of_b, v, cross(u, v)))
    towards = dot(n, minus(origin(b), origin(a)))
    return scaled(n, where(towards < 0.0, -1.0, 1.0) / sqrt(dot(n, n)))


@kernel
def pose_axis(a, k):
    """Axis k of a pose, where k is a number of lanes."""
    return chosen(k < 0.5, x_axis(a), chosen(k < 1.5, y_axis(a), z_axis(a)))


@kernel
def nearest_points(r, t, h, g):
    """The minimum squared distance over the 25 pairs, and its pair, in the frame of A.

    r: The rows of R_a_b. t: t_a_b.
    """
    x, y, z = columns(r)
    edges = scaled(x, g[0]), scaled(y, g[1]), scaled(z, g[2])
    square, q = nearest_corner(t, edges, h)
    best = square, inside(q, h), q
    square, corner = nearest_corner(
        transposed_times(r, scaled(t, -1.0)), (scaled(r[0], h[0]), scaled(r[1], h[1]), scaled(r[2], h[2])), g
    )
    best = nearer_points(best, (square, point_in_a(r, t, corner), point_in_a(r, t, inside(corner, g))))
    sx, sy, sz = columns(signs(r))
    best = nearest_edges(best, t, h, x, g[0], (edges[1], edges[2]), (sx, sy, sz))
    best = nearest_edges(best, t, h, y, g[1], (edges[2], edges[0]), (sy, sz, sx))
    return nearest_edges(best, t, h, z, g[2], (edges[0], edges[1]), (sz, sx, sy))


@kernel
def inside(p, h):
    """The point nearest to p in the box with half extents h, centered at the origin."""
    return clamp(p[0], h[0]), clamp(p[1], h[1]), clamp(p[2], h[2])


@kernel
def nearest_corner(c, edges, h):
    """The corner c +- x +- y +- z nearest to a box about the origin, after its squared distance."""
    x, y, z = edges
    return nearer_corner(nearest_of_four(plus(c, x), y, z, h), nearest_of_four(minus(c, x), y, z, h))


@kernel
def nearest_of_four(c, y, z, h):
    """``nearest_corner`` of the corners c +- y +- z alone."""
    p, q = plus(c, y), minus(c, y)
    return nearer_corner(
        nearer_corner(outside_square(plus(p, z), h), outside_square(minus(p, z), h)),
        nearer_corner(outside_square(plus(q, z), h), outside_square(minus(q, z), h)),
    )


@kernel
def nearer_points(best, other):
    """The nearer of two pairs, each a squared distance and two points."""
    mask = other[0] < best[0]
    return where(mask, other[0], best[0]), chosen(mask, other[1], best[1]), chosen(mask, other[2], best[2])


@kernel
def nearer_corner(best, other):
    """The nearer of two corners, each a squared distance and a point."""
    mask = other[0] < best[0]
    return where(mask, other[0], best[0]), chosen(mask, other[1], best[1])


@kernel
def outside_square(p, h):
    """The squared distance of p from a box about the origin, and p."""
    x, y, z = maximum(abs(p[0]) - h[0], 0.0), maximum(abs(p[1]) - h[1], 0.0), maximum(abs(p[2]) - h[2], 0.0)
    return x * x + y * y + z * z, p


@kernel
def signs(r):
    """The signs of the entries of R_a_b after a tiny tilt of B, which gives a sign to zeros."""
    return row_signs(r[0]), row_signs(r[1]), row_signs(r[2])


@kernel
def row_signs(row):
    """The signs of one row."""
    x, y, z = _TILT
    return (
        where(row[0] + (z * row[1] - y * row[2]) < 0.0, -1.0, 1.0),
        where(row[1] + (x * row[2] - z * row[0]) < 0.0, -1.0, 1.0),
        where(row[2] + (y * row[0] - x * row[1]) < 0.0, -1.0, 1.0),
    )


@kernel
def nearest_edges(best, t, h, d, length, sides, s):
    """Update the best pair with an edge of B along d and each of the three edge directions of A.

    sides: Vectors from the axis of B to these edges, along the next axis of B and the one after. s: The signs by column, of d and
    of these two axes.
    """
    y, z = sides
    of_d, of_y, of_z = s
    best = nearer_points(best, edge_pair(t, h, d, length, (y, z), (of_d[1], of_d[2], of_y[0], of_z[0])))
    t, h, d, y, z = cycled(t), cycled(h), cycled(d), cycled(y), cycled(z)
    square, p, q = edge_pair(t, h, d, length, (y, z), (of_d[2], of_d[0], of_y[1], of_z[1]))
    best = nearer_points(best, (square, cycled(cycled(p)), cycled(cycled(q))))
    t, h, d, y, z = cycled(t), cycled(h), cycled(d), cycled(y), cycled(z)
    square, p, q = edge_pair(t, h, d, length, (y, z), (of_d[0], of_d[1], of_y[2], of_z[2]))
    return nearer_points(best, (square, cycled(p), cycled(q)))


@kernel
def cycled(v):
    """The vector in cyclically renumbered axes: 1, 2, 0."""
    return v[1], v[2], v[0]


@kernel
def edge_pair(t, h, d, length, sides, s):
    """Nearest points of an edge of A along axis 0 and an edge of B along d.

    Both are the outermost edges along their common perpendicular.

    1. n = (0, -d2, d1) is the perpendicular; ``towards`` orients it from A to B. A's edge lies on the side of n, B's edge on the
       other side. B's edge passes through t +- y +- z. With y, z and d the axes of B in cyclic order, n . y has the sign of entry
       0 of z, and n . z the sign of minus entry 0 of y.
    2. Seen along axis 0, A's edge is a point. Take the nearest point of B's line to it, clamped to the edge, then the nearest
       point of A's edge. If the edges do not cross, the result is still a pair of points of the boxes.

    s: The signs of entries 1 and 2 of d, and of entry 0 of y and of z.
    """
    (y, z), (sign_1, sign_2, sign_y, sign_z) = sides, s
    towards = where(t[2] * d[1] - t[1] * d[2] < 0.0, -1.0, 1.0)
    p1, p2 = -(towards * sign_2 * h[1]), towards * sign_1 * h[2]
    i, j = -(towards * sign_z), towards * sign_y
    c = (t[0] + i * y[0] + j * z[0], t[1] + i * y[1] + j * z[1], t[2] + i * y[2] + j * z[2])
    square = d[1] * d[1] + d[2] * d[2]
    along = (d[1] * (p1 - c[1]) + d[2] * (p2 - c[2])) / where(square > 0.0, square, 1.0)
    along = clamp(along, length)
    q = (c[0] + along * d[0], c[1] + along * d[1], c[2] + along * d[2])
    p0 = clamp(q[0], h[0])
    x, y, z = q[0] - p0, q[1] - p1, q[2] - p2
    return x * x + y * y + z * z, (p0, p1, p2), q
