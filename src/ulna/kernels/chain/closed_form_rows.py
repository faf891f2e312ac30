"""Reads the tables of a closed form, rotates vectors in the frames of its axes, and writes branches.

The frame F of an axis h has the columns n, h x n and h (NORMALS and AXES of the table). A rotation about the axis changes only
two coordinates there. A matrix is a tuple of three rows.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, sqrt, store, where
from ulna.kernels.chain.closed_form_layout import (
    AXES,
    COINCIDE,
    COINCIDING,
    COLUMNS,
    COMPLETE,
    COMPLEX,
    CONTINUUM,
    DETERMINED,
    FIFTH,
    HARDLY_DETERMINED,
    IS_COINCIDING,
    IS_HARDLY_DETERMINED,
    IS_REAL,
    N_KNOWN,
    NORMALS,
    OF_6,
    REACHED,
    RESIDUAL,
    SEPARATION,
    SIGNS,
    UNPROVED,
)
from ulna.kernels.spatial.vectors import dot, rotate


@kernel
def tabled(table, i):
    """The vector in row i."""
    return table[i, 0], table[i, 1], table[i, 2]


@kernel
def in_frame(table, normals, i, v):
    """F' v for the frame of axis i; ``normals`` is the first of its rows in NORMALS."""
    return dot(tabled(table, NORMALS + normals), v), dot(tabled(table, NORMALS + normals + 1), v), dot(tabled(table, AXES + i), v)


@kernel
def rotate_in_frame(angle, v):
    """A vector in the frame of an axis, rotated about the axis by an angle."""
    s, c = angle
    return c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]


@kernel
def rotate_back_in_frame(angle, v):
    """A vector in the frame of an axis, rotated about the axis by the opposite angle."""
    s, c = angle
    return c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]


@kernel
def column(r, i):
    """A column of a matrix."""
    return r[0][i], r[1][i], r[2][i]


@kernel
def by_columns(r, x, y, z):
    """The matrix R' (x y z) for three columns, with R given by its columns r."""
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


@kernel
def free_angle(free_rows, j):
    """The value of angle j if it is undetermined; free_rows: Six sines, then six cosines."""
    return load(free_rows, j), load(free_rows, 6 + j)


@kernel
def store_angle(table, q_rows, branch, j, angle):
    """Write the angle about axis j to its entry of q."""
    store(q_rows, 6 * branch + int(table[COLUMNS + j // 3, j % 3]), angle * table[SIGNS + j // 3, j % 3])


@kernel
def store_properties(known_rows, branch, square, determination, separation):
    """Write the properties of a branch; ``square`` is the square of the residual."""
    row = N_KNOWN * branch
    store(known_rows, row + RESIDUAL, sqrt(square))
    store(known_rows, row + DETERMINED, determination)
    store(known_rows, row + SEPARATION, separation)


@kernel
def properties_in_one(known_rows, branch):
    """The properties of a branch, as a sum of flags (``closed_form_layout``)."""
    row = N_KNOWN * branch
    real = load(known_rows, row + RESIDUAL) <= REACHED
    hardly = where(is_in_doubt(known_rows, row), IS_HARDLY_DETERMINED * 1.0, 0.0)
    coincide = where(load(known_rows, row + SEPARATION) <= COINCIDING, IS_COINCIDING * 1.0, 0.0)
    return where(real, IS_REAL * 1.0, 0.0) + hardly + coincide


@kernel
def is_in_doubt(known_rows, row):
    """Whether the angles of a branch may have other values.

    Either they are hardly determined, or the target is missed and no pair of roots is certainly complex.
    """
    separation, is_missed = load(known_rows, row + SEPARATION), load(known_rows, row + RESIDUAL) > REACHED
    return (load(known_rows, row + DETERMINED) <= HARDLY_DETERMINED) | (is_missed & (separation >= COMPLEX))


@kernel
def doubts(known_rows, row):
    """Masks for a branch: real with an undetermined angle; an undetermined angle; coinciding with another branch."""
    real, hardly = load(known_rows, row + RESIDUAL) <= REACHED, is_in_doubt(known_rows, row)
    return real & hardly, hardly, real & (load(known_rows, row + SEPARATION) <= COINCIDING)


@kernel
def proof_of_lanes(known_rows):
    """The proof by the branches of one target, one branch a lane; see ``proof_of``."""
    free_real, free, coincide = doubts(known_rows, 0)
    if any_lane(free_real):
        return CONTINUUM
    if any_lane(free):
        return UNPROVED
    return COINCIDE if any_lane(coincide) else COMPLETE


@kernel
def proof_of(known_rows):
    """The proof by the branches of a target (``closed_form_layout``).

    If an unsolved branch has an undetermined angle, another value may solve it, so nothing is proved.
    """
    like = load(known_rows, RESIDUAL)
    free_real, free, coincide = 0.0 * like, 0.0 * like, 0.0 * like
    for branch in range(known_rows.shape[0] // N_KNOWN):
        doubts_of_branch = doubts(known_rows, N_KNOWN * branch)
        free_real, free = where(doubts_of_branch[0], 1.0, free_real), where(doubts_of_branch[1], 1.0, free)
        coincide = where(doubts_of_branch[2], 1.0, coincide)
    finite = where(coincide > 0.0, COINCIDE * 1.0, COMPLETE * 1.0)
    return where(free_real > 0.0, CONTINUUM * 1.0, where(free > 0.0, UNPROVED * 1.0, finite))
