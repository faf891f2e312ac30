"""Tests two oriented boxes by the fifteen axes of the separating-axis theorem.

Two convex bodies are apart exactly if their projections on some axis are. For boxes the three face normals of each and the nine
cross products of their edges suffice. A gap is the distance between the projections; for overlapping projections it is minus
their overlap. Boxes that touch, within the tolerance ``CONTACT``, count as overlapping.

Source: Gottschalk, Lin and Manocha, OBBTree (SIGGRAPH 1996), section 5; the layout follows Ericson, Real-Time Collision Detection
(2005), section 4.4.1.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import splat, sqrt, where
from ulna.kernels.layout import CONTACT
from ulna.kernels.spatial.elementary import maximum
from ulna.kernels.spatial.vectors import origin, plus, rotate_inverse, times, transform_inverse, x_axis, y_axis, z_axis

# Two edges within 1e-8 rad of parallel give no axis of their own: the product of such unit vectors has no accurate
# direction. The face normals separate as well as that axis would, to 1e-8 of the boxes' size.
_PARALLEL = 1e-16  # the square of the sine of that angle
_NEVER = -1e300
_ROUNDING = 2e-15  # of the boxes' size: rounding of a gap that is scaled by the length of its axis


@kernel
def relative_pose(a, b):
    """Pose b in the frame of pose a: R_a_b as three rows of three, and t_a_b."""
    r = rotate_inverse(b, x_axis(a)), rotate_inverse(b, y_axis(a)), rotate_inverse(b, z_axis(a))
    return r, transform_inverse(a, origin(b))


@kernel
def columns(r):
    """The columns of a matrix of three rows."""
    return (r[0][0], r[1][0], r[2][0]), (r[0][1], r[1][1], r[2][1]), (r[0][2], r[1][2], r[2][2])


@kernel
def point_in_a(r, t, p):
    """A point of the frame of B in the frame of A: R p + t."""
    return plus(times(r, p), t)


@kernel
def face_gaps(r, m, t, h, g):
    """The gaps along the three face normals of A (half extents h), then along those of B (g).

    m: The absolute values of the entries of r.
    """
    return (
        abs(t[0]) - h[0] - (g[0] * m[0][0] + g[1] * m[0][1] + g[2] * m[0][2]),
        abs(t[1]) - h[1] - (g[0] * m[1][0] + g[1] * m[1][1] + g[2] * m[1][2]),
        abs(t[2]) - h[2] - (g[0] * m[2][0] + g[1] * m[2][1] + g[2] * m[2][2]),
        abs(t[0] * r[0][0] + t[1] * r[1][0] + t[2] * r[2][0]) - g[0] - (h[0] * m[0][0] + h[1] * m[1][0] + h[2] * m[2][0]),
        abs(t[0] * r[0][1] + t[1] * r[1][1] + t[2] * r[2][1]) - g[1] - (h[0] * m[0][1] + h[1] * m[1][1] + h[2] * m[2][1]),
        abs(t[0] * r[0][2] + t[1] * r[1][2] + t[2] * r[2][2]) - g[2] - (h[0] * m[0][2] + h[1] * m[1][2] + h[2] * m[2][2]),
    )


@kernel
def edge_gaps(t, h, r, m, g):
    """The gaps along the products of one edge of A with the three of B, scaled by the products' lengths.

    The second result is the squared lengths. A's axes are numbered 0, 1, 2 from this edge on. t, h: A's entries 1 and 2. r: The
    rows of these two axes. m: The absolute rows of all three axes.
    """
    (t1, t2), (h1, h2), (r1, r2), (m0, m1, m2) = t, h, r, m
    return (
        (
            abs(t2 * r1[0] - t1 * r2[0]) - (h1 * m2[0] + h2 * m1[0]) - (g[1] * m0[2] + g[2] * m0[1]),
            abs(t2 * r1[1] - t1 * r2[1]) - (h1 * m2[1] + h2 * m1[1]) - (g[2] * m0[0] + g[0] * m0[2]),
            abs(t2 * r1[2] - t1 * r2[2]) - (h1 * m2[2] + h2 * m1[2]) - (g[0] * m0[1] + g[1] * m0[0]),
        ),
        (r1[0] * r1[0] + r2[0] * r2[0], r1[1] * r1[1] + r2[1] * r2[1], r1[2] * r1[2] + r2[2] * r2[2]),
    )


@kernel
def all_gaps(a, h, b, g):
    """The six face gaps, and each edge of A's three edge gaps with their axes' squared lengths."""
    r, t = relative_pose(a, b)
    m = sizes(r[0]), sizes(r[1]), sizes(r[2])
    return (
        face_gaps(r, m, t, h, g),
        edge_gaps((t[1], t[2]), (h[1], h[2]), (r[1], r[2]), (m[0], m[1], m[2]), g),
        edge_gaps((t[2], t[0]), (h[2], h[0]), (r[2], r[0]), (m[1], m[2], m[0]), g),
        edge_gaps((t[0], t[1]), (h[0], h[1]), (r[0], r[1]), (m[2], m[0], m[1]), g),
    )


@kernel
def sizes(v):
    """The absolute values of three numbers."""
    return abs(v[0]), abs(v[1]), abs(v[2])


@kernel
def widest_of_edges(edges):
    """The widest of one edge's gaps with a usable axis, scaled by the axis' length: only its sign counts."""
    gap, square = edges
    return maximum(
        maximum(where(square[0] > _PARALLEL, gap[0], _NEVER), where(square[1] > _PARALLEL, gap[1], _NEVER)),
        where(square[2] > _PARALLEL, gap[2], _NEVER),
    )


@kernel
def boxes_overlap(a, h, b, g):
    """True where two boxes share a point: at poses a and b, with half extents h and g.

    It needs no division and no square root, since the sign of a gap does not depend on the length of its axis. The product of
    nearly parallel edges is short, and rounding makes its gap useless as a proof.
    """
    size = h[0] + h[1] + h[2] + g[0] + g[1] + g[2]
    margin = CONTACT * size
    f, e0, e1, e2 = all_gaps(a, (h[0] + margin, h[1] + margin, h[2] + margin), b, g)
    faces = maximum(maximum(maximum(f[0], f[1]), maximum(f[2], f[3])), maximum(f[4], f[5]))
    edges = maximum(maximum(widest_of_edges(e0), widest_of_edges(e1)), widest_of_edges(e2))
    return maximum(faces, edges - _ROUNDING * size) <= 0.0


@kernel
def widest_gap(a, h, b, g):
    """The widest gap over the fifteen axes [m] and the number of its axis.

    Negative: the boxes overlap, and this is minus their exact penetration depth. The shortest translation that separates two
    convex polytopes is along a face normal, or along a product of their edges. Positive: they are at least this far apart. Axes
    0-2 are the face normals of A, axes 3-5 those of B. Axis 6 + 3 i + j is the product of edge i of A and edge j of B.
    """
    f, e0, e1, e2 = all_gaps(a, h, b, g)
    widest, axis = f[0], splat(0.0, f[0])
    for k in range(1, 6):
        widest, axis = keep_wider(widest, axis, f[k], k)
    for k in range(3):
        widest, axis = keep_wider(widest, axis, true_gap(e0[0][k], e0[1][k]), 6 + k)
    for k in range(3):
        widest, axis = keep_wider(widest, axis, true_gap(e1[0][k], e1[1][k]), 9 + k)
    for k in range(3):
        widest, axis = keep_wider(widest, axis, true_gap(e2[0][k], e2[1][k]), 12 + k)
    return widest, axis


@kernel
def certain_gap(a, h, b, g, rounding):
    """A lower bound of the distance of two boxes [m]: the widest of the fifteen gaps, less rounding.

    rounding: That of a gap along a unit vector [m]. It is divided by the length of a short axis.
    """
    f, e0, e1, e2 = all_gaps(a, h, b, g)
    widest = maximum(maximum(maximum(f[0], f[1]), maximum(f[2], f[3])), maximum(f[4], f[5])) - rounding
    for k in range(3):
        of_0, of_1 = true_gap(e0[0][k] - rounding, e0[1][k]), true_gap(e1[0][k] - rounding, e1[1][k])
        widest = maximum(maximum(widest, of_0), maximum(of_1, true_gap(e2[0][k] - rounding, e2[1][k])))
    return widest


@kernel
def true_gap(gap, square):
    """An edge gap in meters; hugely negative where the edges are parallel."""
    usable = square > _PARALLEL
    return where(usable, gap / sqrt(where(usable, square, 1.0)), _NEVER)


@kernel
def keep_wider(widest, axis, gap, k):
    """The wider of the widest gap and the gap of axis k, with its axis."""
    wider = gap > widest
    return where(wider, gap, widest), where(wider, float(k), axis)
