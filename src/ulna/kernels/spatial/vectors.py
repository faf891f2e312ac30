"""Adds, scales, multiplies and rotates vectors of three numbers. Used by all other kernels."""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import where


@kernel
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def times(a, x):
    """The vector a times a number."""
    return a[0] * x, a[1] * x, a[2] * x


@kernel
def step(a, x, b):
    """a + x b."""
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
    """a where the mask is true, b elsewhere."""
    return where(mask, a[0], b[0]), where(mask, a[1], b[1]), where(mask, a[2], b[2])


@kernel
def axis(a, k):
    """Axis k (0, 1 or 2, a plain number) of a pose."""
    return a[k], a[4 + k], a[8 + k]


@kernel
def origin(a):
    """The origin of a pose."""
    return a[3], a[7], a[11]


@kernel
def turn(a, v):
    """The vector v, given in the axes of pose a, in the axes of the frame in which a is given: R v."""
    return (
        a[0] * v[0] + a[1] * v[1] + a[2] * v[2],
        a[4] * v[0] + a[5] * v[1] + a[6] * v[2],
        a[8] * v[0] + a[9] * v[1] + a[10] * v[2],
    )


@kernel
def turn_into(a, v):
    """The vector v, given in the frame in which pose a is given, in the axes of a: R' v."""
    return (
        a[0] * v[0] + a[4] * v[1] + a[8] * v[2],
        a[1] * v[0] + a[5] * v[1] + a[9] * v[2],
        a[2] * v[0] + a[6] * v[1] + a[10] * v[2],
    )


@kernel
def place(a, p):
    """The point p, given in the frame of pose a, in the frame in which a is given: R p + t."""
    return plus(turn(a, p), origin(a))


@kernel
def seen_from(a, p):
    """The point p, given in the frame in which pose a is given, in the frame of a: R' (p - t)."""
    return turn_into(a, minus(p, origin(a)))
