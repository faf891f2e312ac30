"""Computes with the inertia of a rigid body: ten numbers for its mass, first moment and tensor.

The first moment is the mass times the center of mass. The tensor is about the origin of the frame, so that inertias in one frame
add up.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), section 2.13.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, splat, store
from ulna.kernels.layout import INERTIA_WIDTH, MASS, MOMENT, TENSOR
from ulna.kernels.spatial.vectors import add_scaled, cross, dot, load_vector, origin, plus, rotate, scaled, store_vector


@kernel
def body_inertia(bodies, i, like):
    """The mass, the moment and the tensor of row i of a table of inertias."""
    return (
        splat(bodies[i, MASS], like),
        (splat(bodies[i, MOMENT], like), splat(bodies[i, MOMENT + 1], like), splat(bodies[i, MOMENT + 2], like)),
        (
            splat(bodies[i, TENSOR], like), splat(bodies[i, TENSOR + 1], like), splat(bodies[i, TENSOR + 2], like),
            splat(bodies[i, TENSOR + 3], like), splat(bodies[i, TENSOR + 4], like), splat(bodies[i, TENSOR + 5], like),
        ),
    )  # fmt: skip


@kernel
def symmetric_times(s, v):
    """The product of a symmetric matrix (xx, xy, xz, yy, yz, zz) and a vector."""
    return (
        s[0] * v[0] + s[1] * v[1] + s[2] * v[2],
        s[1] * v[0] + s[3] * v[1] + s[4] * v[2],
        s[2] * v[0] + s[4] * v[1] + s[5] * v[2],
    )


@kernel
def momentum(inertia, v, w):
    """The linear and the angular momentum of a body with the motion (v, w)."""
    mass, moment, tensor = inertia
    return plus(scaled(v, mass), cross(w, moment)), plus(symmetric_times(tensor, w), cross(moment, v))


@kernel
def to_parent_frame(pose, inertia):
    """Transform an inertia to the parent frame.

    1. Rotate the moment, h = R h', and the tensor, R T R'.
    2. Translate by p, x = p + r. The rotated tensor is the integral of |r|^2 I - r r', the new one that of |x|^2 I - x x'. Their
       difference is m (|p|^2 I - p p') + 2 (p . h) I - p h' - h p'. The moment becomes h + m p.
    """
    mass, moment, tensor = inertia
    p, h = origin(pose), rotate(pose, moment)
    turned = rotate_tensor(pose, tensor)
    k = add_scaled(h, 0.5 * mass, p)  # p k' + k p' = m p p' + p h' + h p'
    trace = 2.0 * dot(p, k)
    moved = (
        turned[0] + trace - 2.0 * p[0] * k[0], turned[1] - p[0] * k[1] - p[1] * k[0], turned[2] - p[0] * k[2] - p[2] * k[0],
        turned[3] + trace - 2.0 * p[1] * k[1], turned[4] - p[1] * k[2] - p[2] * k[1], turned[5] + trace - 2.0 * p[2] * k[2],
    )  # fmt: skip
    return mass, add_scaled(h, mass, p), moved


@kernel
def rotate_tensor(a, s):
    """The product R S R' with the rotation R of a pose and a symmetric matrix S."""
    x, y, z = (a[0], a[1], a[2]), (a[4], a[5], a[6]), (a[8], a[9], a[10])
    sx, sy, sz = symmetric_times(s, x), symmetric_times(s, y), symmetric_times(s, z)
    return dot(x, sx), dot(x, sy), dot(x, sz), dot(y, sy), dot(y, sz), dot(z, sz)


@kernel
def add_inertias(a, b):
    """The sum of two inertias in the same frame."""
    s, t = a[2], b[2]
    return a[0] + b[0], plus(a[1], b[1]), (s[0] + t[0], s[1] + t[1], s[2] + t[2], s[3] + t[3], s[4] + t[4], s[5] + t[5])


@kernel
def load_inertia(rows, i):
    """Load inertia i from rows, ten rows each."""
    k = INERTIA_WIDTH * i
    return load(rows, k), load_vector(rows, k + 1), load_vector(rows, k + 4) + load_vector(rows, k + 7)


@kernel
def store_inertia(rows, i, inertia):
    """Write an inertia to position i of the rows."""
    k = INERTIA_WIDTH * i
    store(rows, k, inertia[0])
    store_vector(rows, k + 1, inertia[1])
    for j in range(6):
        store(rows, k + 4 + j, inertia[2][j])


@kernel
def load_pair(rows, i):
    """Load motion or wrench i from rows, six rows each."""
    return load_vector(rows, 6 * i), load_vector(rows, 6 * i + 3)


@kernel
def store_pair(rows, i, linear, angular):
    """Write a motion or a wrench to position i of the rows."""
    store_vector(rows, 6 * i, linear)
    store_vector(rows, 6 * i + 3, angular)


@kernel
def add_pair(rows, i, linear, angular):
    """Add to the motion or the wrench at position i of the rows."""
    before_linear, before_angular = load_pair(rows, i)
    store_pair(rows, i, plus(before_linear, linear), plus(before_angular, angular))


@kernel
def pair_dot(a, b):
    """The power of a wrench along a motion: the sum of both inner products."""
    return dot(a[0], b[0]) + dot(a[1], b[1])


@kernel
def motion_cross(a, b):
    """The rate of a motion b that moves with a: a x b."""
    return plus(cross(a[1], b[0]), cross(a[0], b[1])), cross(a[1], b[1])


@kernel
def wrench_cross(a, f):
    """The rate of a wrench f that moves with a: a x* f."""
    return cross(a[1], f[0]), plus(cross(a[1], f[1]), cross(a[0], f[0]))


@kernel
def pair_plus(a, b):
    """The sum of two motions or wrenches."""
    return plus(a[0], b[0]), plus(a[1], b[1])


@kernel
def pair_scaled(a, x):
    """A motion or a wrench times a number."""
    return scaled(a[0], x), scaled(a[1], x)
