"""Turns vectors in the frame of an axis, where a turn about it changes two numbers.

The frame F of an axis h has the columns n, h x n and h (NORMALS and AXES of the table). A matrix is a tuple of three rows.
"""

from ulna.engine.decorators import kernel
from ulna.kernels.chain.closed_form_layout import AXES, FIFTH, NORMALS, OF_6
from ulna.kernels.chain.closed_form_rows import tabled
from ulna.kernels.spatial.vectors import dot, rotate


@kernel
def in_frame(table, normals, i, v):
    """F' v for the frame of axis i; ``normals``: where its rows of NORMALS begin."""
    return dot(tabled(table, NORMALS + normals), v), dot(tabled(table, NORMALS + normals + 1), v), dot(tabled(table, AXES + i), v)


@kernel
def turned(angle, v):
    """A vector in the frame of an axis, turned about that by an angle."""
    s, c = angle
    return c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]


@kernel
def turned_back(angle, v):
    """A vector in the frame of an axis, turned about that by the opposite angle."""
    s, c = angle
    return c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]


@kernel
def column(r, i):
    """A column of a matrix."""
    return r[0][i], r[1][i], r[2][i]


@kernel
def by_columns(r, x, y, z):
    """The matrix R' (x y z) for three columns, and R given by its columns r."""
    return (dot(r[0], x), dot(r[0], y), dot(r[0], z)), (dot(r[1], x), dot(r[1], y), dot(r[1], z)), (
        dot(r[2], x), dot(r[2], y), dot(r[2], z)
    )  # fmt: skip


@kernel
def fifth_turn(table, angle):
    """The matrix F' rot(h_5, angle) F_6 (FIFTH)."""
    return fifth_row(table, 0, angle), fifth_row(table, 1, angle), fifth_row(table, 2, angle)


@kernel
def fifth_row(table, i, angle):
    """Row i of ``fifth_turn``."""
    s, c = angle
    k, a, b = tabled(table, FIFTH + i), tabled(table, FIFTH + 3 + i), tabled(table, FIFTH + 6 + i)
    return k[0] + a[0] * c + b[0] * s, k[1] + a[1] * c + b[1] * s, k[2] + a[2] * c + b[2] * s


@kernel
def end_frame(table, motion):
    """R F_6: three columns."""
    x, y = rotate(motion, tabled(table, NORMALS + OF_6)), rotate(motion, tabled(table, NORMALS + OF_6 + 1))
    return x, y, rotate(motion, tabled(table, AXES + 5))
