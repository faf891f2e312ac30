"""Adds, scales, multiplies, rotates, loads and stores vectors of three numbers."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, store, where


@kernel
def load_vector(rows, j):
    """Load a vector from rows j, j + 1, j + 2."""
    return load(rows, j), load(rows, j + 1), load(rows, j + 2)


@kernel
def store_vector(rows, j, v):
    """Write a vector to rows j, j + 1, j + 2."""
    store(rows, j, v[0])
    store(rows, j + 1, v[1])
    store(rows, j + 2, v[2])


@kernel
def plus(a, b):
    """The sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def minus(a, b):
    """The difference a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def scaled(a, x):
    """The vector a times the number x."""
    return a[0] * x, a[1] * x, a[2] * x


@kernel
def add_scaled(a, x, b):
    """The sum a + x b."""
    return a[0] + x * b[0], a[1] + x * b[1], a[2] + x * b[2]


@kernel
def dot(a, b):
    """The inner product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """The cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def chosen(mask, a, b):
    """The vector a where the mask is true, b elsewhere."""
    return where(mask, a[0], b[0]), where(mask, a[1], b[1]), where(mask, a[2], b[2])


@kernel
def x_axis(a):
    """The x axis of a pose."""
    return a[0], a[4], a[8]


@kernel
def y_axis(a):
    """The y axis of a pose."""
    return a[1], a[5], a[9]


@kernel
def z_axis(a):
    """The z axis of a pose."""
    return a[2], a[6], a[10]


@kernel
def origin(a):
    """The origin of a pose."""
    return a[3], a[7], a[11]


@kernel
def rotate(a, v):
    """Transform the vector v from the axes of pose a to its parent's axes: R v."""
    return (
        a[0] * v[0] + a[1] * v[1] + a[2] * v[2],
        a[4] * v[0] + a[5] * v[1] + a[6] * v[2],
        a[8] * v[0] + a[9] * v[1] + a[10] * v[2],
    )


@kernel
def rotate_inverse(a, v):
    """Transform the vector v from the parent's axes to the axes of pose a: R' v."""
    return (
        a[0] * v[0] + a[4] * v[1] + a[8] * v[2],
        a[1] * v[0] + a[5] * v[1] + a[9] * v[2],
        a[2] * v[0] + a[6] * v[1] + a[10] * v[2],
    )


@kernel
def transform(a, p):
    """Transform the point p from the frame of pose a to its parent frame: R p + t."""
    return plus(rotate(a, p), origin(a))


@kernel
def transform_inverse(a, p):
    """Transform the point p from the parent frame to the frame of pose a: R' (p - t)."""
    return rotate_inverse(a, minus(p, origin(a)))


@kernel
def times(r, v):
    """The product R v, for a matrix of three rows."""
    return dot(r[0], v), dot(r[1], v), dot(r[2], v)


@kernel
def transposed_times(r, v):
    """The product R' v, for a matrix of three rows."""
    return (
        r[0][0] * v[0] + r[1][0] * v[1] + r[2][0] * v[2],
        r[0][1] * v[0] + r[1][1] * v[1] + r[2][1] * v[2],
        r[0][2] * v[0] + r[1][2] * v[1] + r[2][2] * v[2],
    )
