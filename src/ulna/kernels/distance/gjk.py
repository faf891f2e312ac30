"""Computes the distance of two separate convex cores by the Gilbert-Johnson-Keerthi algorithm (GJK).

The distance of A and B is the distance of the origin from their Minkowski difference, the convex set of all p - q. Its support
point along a direction is a difference of support points. The search keeps a simplex of up to three such points and v, its point
nearest to the origin. With the support point w along -v, the distance is at least v . w / |v| and at most |v|. The search ends
when the two bounds agree, so the result is certified.

One step: with w, the triangle K0 K1 K2 becomes a tetrahedron. w is farther along -v than all earlier points. So the tetrahedron's
nearest point is the old one, or lies on a feature that contains w: on one of three edges or three triangles. All six candidates
are computed, each a point of the set, and the nearest is kept. So no step increases |v|, even for degenerate simplices, and all
lanes take the same path. For robustness it follows Montanari, Petrinic and Barbieri (ACM Trans. Graphics 36, 2017). Normals are
cross products. The nearest point of a face is computed along the face's normal, not as a weighted sum of its corners.

For bodies that are long in relation to their distance, the lower bound needs v in more digits: a wire of a kilometer may pass a
box at micrometers. A weighted sum of corners has only the digits of the corners. So v is computed again once its feature is known
(``point_of``): along the normal of a face, from the two shortest edges; or perpendicular to an edge.

Source: Gilbert, Johnson and Keerthi, IEEE J. Robotics and Automation 1988.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, logical_not, splat, sqrt, where
from ulna.kernels.distance.body_records import Simplex
from ulna.kernels.distance.box_sat import point_in_a, relative_pose
from ulna.kernels.distance.support import support
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import add_scaled, chosen, cross, dot, minus, rotate, scaled, transform, transposed_times

STEPS = 128
_FAR = 1e300
# Squares of the sine of an angle. The normal of a thinner triangle has few accurate digits, or none.
_NEEDLE, _FLAT = 1e-6, 1e-20
_EXACT = 1e-12  # of the bodies' size: the bounds have converged
_TOUCHING = 1e-12  # of the bodies' size: cores this near to each other count as touching
_NOISE = 2e-15  # of the bodies' size: rounding of a point; a smaller gain does not count
_SURE = 1e-14  # the rounding of a triple product, relative to the product of the lengths


@kernel
def nearest_cores(a, core_a, b, core_b, reach):
    """Nearest points of two cores at poses a and b.

    reach: A lane also ends once its distance is certainly above this [m], or certainly not. A negative reach turns this off.

    Returns:
        A lower bound of the distance and the distance of the points, both [m] and zero where the cores overlap; the points p of A
        and q of B; the unit normal from p to q; and a mask of the lanes where the cores overlap.
    """
    relative = relative_pose(a, b)
    t = relative[1]
    size = core_bound(core_a.half) + core_bound(core_b.half) + abs(t[0]) + abs(t[1]) + abs(t[2])
    w, p = difference(core_a, core_b, relative, (-t[0], -t[1], -t[2]))
    zero = splat(0.0, t[0])
    simplex = Simplex(w, (w, w, w), (p, p, p), (zero + 1.0, zero, zero))
    below, noise, inside, active = zero - _FAR, _NOISE * size, zero > 1.0, zero < 1.0
    for _ in range(STEPS):
        v = simplex.v
        distance = sqrt(dot(v, v))
        touching = distance <= _TOUCHING * size
        inside = inside | (active & touching)
        active = active & logical_not(touching)
        w, p = difference(core_a, core_b, relative, v)
        bound = dot(v, w) / where(touching, 1.0, distance)
        gained = bound > below + noise
        below = where(active & (bound > below), bound, below)
        done = distance - below <= _EXACT * size
        done = done | ((reach >= 0.0) & ((below > reach) | (distance <= reach)))
        active = active & logical_not(done)
        if not any_lane(active):
            break
        simplex, new, within = advance(active, simplex, w, p, distance, noise, size)
        within = within & active & (below <= _EXACT * size)
        inside = inside | within
        active = active & (new | gained) & logical_not(within)
    inside = inside | (below <= 0.0)  # no certain gap: EPA computes the depth
    v, _, sources, weights = simplex
    distance = where(inside, 0.0, sqrt(dot(v, v)))
    n = scaled(v, -1.0 / where(inside, 1.0, distance))
    p = add_scaled(add_scaled(scaled(sources[0], weights[0]), weights[1], sources[1]), weights[2], sources[2])
    return where(inside, 0.0, below), distance, transform(a, p), transform(a, minus(p, v)), rotate(a, n), inside


@kernel
def core_bound(h):
    """An upper bound on the distance of a core's points from its frame's origin."""
    return h[0] + h[1] + h[2]


@kernel
def difference(core_a, core_b, relative, v):
    """The support point along -v of the Minkowski difference of two cores in the frame of A, and its p."""
    r, t = relative  # R_a_b, t_a_b
    p = support(core_a, (-v[0], -v[1], -v[2]))
    q = support(core_b, transposed_times(r, v))
    return minus(p, point_in_a(r, t, q)), p


@kernel
def advance(active, simplex, w, p, distance, noise, size):
    """Add w to the simplex in the active lanes, unless v would move away by more than rounding.

    Returns the simplex; a mask where w is deeper than its three points by more than noise; and a mask where the tetrahedron
    contains the origin. v may stay at the same distance, since its direction may be better.

    A candidate is (|v|^2, weight of the first point, weight of the second): the first and second besides w.
    """
    v, points, sources, weights = simplex
    e0, e1, e2 = minus(points[0], w), minus(points[1], w), minus(points[2], w)
    n0, n1, n2 = cross(e0, e1), cross(e1, e2), cross(e2, e0)
    best0 = nearer_candidate(edge_candidate(w, e0), face_candidate(w, e0, e1, n0))
    best1 = nearer_candidate(edge_candidate(w, e1), face_candidate(w, e1, e2, n1))
    best2 = nearer_candidate(edge_candidate(w, e2), face_candidate(w, e2, e0, n2))
    second, third = best1[0] < best0[0], best2[0] < minimum(best0[0], best1[0])
    _, x, y = nearer_candidate(nearer_candidate(best0, best1), best2)
    k1 = chosen(third, points[2], chosen(second, points[1], points[0]))
    k2 = chosen(third, points[0], chosen(second, points[2], points[1]))
    s1 = chosen(third, sources[2], chosen(second, sources[1], sources[0]))
    s2 = chosen(third, sources[0], chosen(second, sources[2], sources[1]))
    nearest = point_of(w, k1, k2, x, y, chosen(third, n2, chosen(second, n1, n0)))
    level = active & (dot(nearest, nearest) <= (distance + noise) * (distance + noise))
    deeper = minimum(minimum(dot(v, e0), dot(v, e1)), dot(v, e2)) > noise * distance
    grown = Simplex(
        chosen(level, nearest, v),
        chosen_three(level, (w, k1, k2), points),
        chosen_three(level, (p, s1, s2), sources),
        chosen(level, (1.0 - x - y, x, y), weights),
    )
    return grown, level & deeper, holds_origin(w, (e0, e1, e2), (n0, n1, n2), size)


@kernel
def point_of(w, k1, k2, x, y, n):
    """A point of the triangle w, k1, k2 with normal n; k1 and k2 have the weights x and y.

    Its direction keeps all digits. On the edge from w to k1 the point is perpendicular to the edge; inside the triangle it is
    along the normal. For a needle, the normal is best computed from its two shortest edges.
    """
    e, f = minus(k1, w), minus(k2, w)
    v = add_scaled(add_scaled(w, x, e), y, f)
    on_edge, on_face = (y <= 0.0) & (x > 0.0) & (x < 1.0), (x > 0.0) & (y > 0.0)
    square, of_e, of_f = dot(n, n), dot(e, e), dot(f, f)
    needle = on_face & (square < _NEEDLE * of_e * of_f)
    if any_lane(needle):
        g = minus(k2, k1)
        of_g = dot(g, g)
        without_e, without_g = (of_e >= of_f) & (of_e >= of_g), (of_g > of_e) & (of_g >= of_f)
        n = chosen(needle, cross(chosen(without_e, f, e), chosen(without_g, f, g)), n)
        square = dot(n, n)
    on_face = on_face & (square > 0.0)
    share = where(on_face, dot(n, w), -dot(v, e)) / where(on_face, square, where(on_edge, of_e, 1.0))
    return chosen(on_face, scaled(n, share), add_scaled(v, where(on_edge, share, 0.0), e))


@kernel
def chosen_three(mask, a, b):
    """Three points of a where the mask is true, and of b elsewhere."""
    return chosen(mask, a[0], b[0]), chosen(mask, a[1], b[1]), chosen(mask, a[2], b[2])


@kernel
def nearer_candidate(best, other):
    """The nearer of two candidates."""
    mask = other[0] < best[0]
    return where(mask, other[0], best[0]), where(mask, other[1], best[1]), where(mask, other[2], best[2])


@kernel
def edge_candidate(w, e):
    """The nearest point of the edge from w to w + e."""
    length = dot(e, e)
    x = minimum(maximum(-dot(w, e) / where(length > 0.0, length, 1.0), 0.0), 1.0)
    v = add_scaled(w, x, e)
    return dot(v, v), x, 0.0 * x


@kernel
def face_candidate(w, e, f, n):
    """The nearest point of the triangle w, w + e, w + f, with the normal n.

    The candidate is infinitely far if this point is not inside the triangle.
    """
    square = dot(n, n)
    usable = square > _FLAT * (dot(e, e) * dot(f, f))
    scale = 1.0 / where(usable, square, 1.0)
    x, y = dot(cross(f, w), n) * scale, dot(cross(w, e), n) * scale
    within = usable & (x >= 0.0) & (y >= 0.0) & (x + y <= 1.0)
    v = add_scaled(add_scaled(w, x, e), y, f)
    return where(within, dot(v, v), _FAR), x, y


@kernel
def holds_origin(w, edges, normals, size):
    """Mask of the lanes whose tetrahedron contains the origin, by more than rounding at each face.

    The tetrahedron has the corners w and w + each of three edges.
    """
    (e0, e1, e2), (n0, n1, n2) = edges, normals
    volume = dot(n0, e2)
    x, y, z = dot(n1, w) * volume, dot(n2, w) * volume, dot(n0, w) * volume
    rounding = _SURE * size * maximum(maximum(dot(e0, e0), dot(e1, e1)), dot(e2, e2)) * abs(volume)
    return (x < -rounding) & (y < -rounding) & (z < -rounding) & (x + y + z + volume * volume > rounding)
