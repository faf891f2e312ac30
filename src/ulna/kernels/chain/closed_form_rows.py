"""Reads the tables of a closed form, turns vectors in the frames of its axes, says how sure angles are, and writes branches.

The frame F of an axis h has the columns n, h x n and h (NORMALS and AXES of the table). A turn about the axis changes two numbers
there. A matrix is a tuple of three rows.

How much of their digits angles keep that are computed one from the other (``accuracy``): an equation for an angle has two roots.
With ``sure``, a^4 for an amplitude a, and ``apart``, the share of a^2 that its discriminant is, what the equation is off by,
delta, moves the angle by delta / (a sqrt(apart)): at a double root by sqrt(delta / a). The equations of the angles behind it are
off by that much instead of a rounding.

1. The product of a^2 apart over all angles before one is called near: its equation is off by eps / sqrt(near).
2. sure, times (1e9 near)^2 if that is less than 1, is compared with HARDLY_DETERMINED: an amplitude counts as 0 if it is
   less than about thirty times what it is off by.
3. apart, as a signed square, times 1e4 near a^2, or 1e10 near a^2 below 0, if that is less than 1, is compared with COINCIDING
   and COMPLEX. So two roots count as one, and a pair as neither real nor complex for certain, if they are nearer than about
   ten, or a hundred, times what apart is off by.
4. A branch that misses its target is certainly no solution if one of its pairs is certainly complex. If it is in doubt whether
   a pair is complex, the branch stays in doubt, whatever its other angles are.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import any_lane, load, sqrt, store, where
from ulna.kernels.chain.closed_form_layout import (
    APART,
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
    LAST,
    N_KNOWN,
    NORMALS,
    OF_6,
    POINTS,
    REACHED,
    RESIDUAL,
    SIGNS,
    UNDETERMINED,
    UNPROVED,
)
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.vectors import dot, rotate

DOUBLE, DOUBLE_OF_QUARTIC = 1e-15, 1e-20  # least apart: what rounding leaves of a double root, and of a threefold one


@kernel
def tabled(table, i):
    """The vector in row i."""
    return table[i, 0], table[i, 1], table[i, 2]


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


@kernel
def accuracy(near, sure, apart, least):
    """Steps 1 to 3 for an angle that is one of two: near behind it, and sure and apart, as they are compared."""
    amplitude = near_behind(near, sure)
    compared = apart * abs(apart) * minimum(where(apart < 0.0, 1e10, 1e4) * amplitude, 1.0)
    return amplitude * where(compared < COMPLEX, 1.0, minimum(maximum(apart, least), 1.0)), sure_behind(near, sure), compared


@kernel
def near_behind(near, sure):
    """Step 1 for an angle whose equation has one root; an angle that is given by the caller is not off."""
    return near * minimum(sqrt(where(sure > UNDETERMINED, sure, 1.0)), 1.0)


@kernel
def sure_behind(near, sure):
    """Step 2."""
    share = minimum(1e9 * near, 1.0)
    return sure * share * share


@kernel
def near_base(table):
    """Step 1 for the first angle: where the base is far from the arm, a position is the small difference of large numbers."""
    x, y, z = table[POINTS, 0], table[POINTS, 1], table[POINTS, 2]
    u, v, w = table[LAST, 0], table[LAST, 1], table[LAST, 2]
    return 1.0 / (1.0 + x * x + y * y + z * z + u * u + v * v + w * w)


@kernel
def worse(apart, next_apart):
    """Step 4: of two angles, as ``apart`` is compared."""
    return where((apart < 0.0) & (apart >= COMPLEX), apart, minimum(apart, next_apart))


@kernel
def free_angle(free_rows, j):
    """What angle j is to be where any would do: twelve rows, six sines and then six cosines."""
    return load(free_rows, j), load(free_rows, 6 + j)


@kernel
def put(table, q_rows, branch, j, angle):
    """Write the angle about axis j to its entry of q."""
    store(q_rows, 6 * branch + int(table[COLUMNS + j // 3, j % 3]), angle * table[SIGNS + j // 3, j % 3])


@kernel
def put_known(known_rows, branch, square, sure, apart):
    """Write what is known of a branch; ``square`` is that of the residual."""
    row = N_KNOWN * branch
    store(known_rows, row + RESIDUAL, sqrt(square))
    store(known_rows, row + DETERMINED, sure)
    store(known_rows, row + APART, apart)


@kernel
def known_in_one(known_rows, branch):
    """What is known of a branch, as a sum (``closed_form_layout``)."""
    row = N_KNOWN * branch
    real = load(known_rows, row + RESIDUAL) <= REACHED
    hardly = where(is_in_doubt(known_rows, row), IS_HARDLY_DETERMINED * 1.0, 0.0)
    coincide = where(load(known_rows, row + APART) <= COINCIDING, IS_COINCIDING * 1.0, 0.0)
    return where(real, IS_REAL * 1.0, 0.0) + hardly + coincide


@kernel
def is_in_doubt(known_rows, row):
    """Whether the angles of a branch may be others: they are hardly determined, or it is missed and no pair is surely complex."""
    apart, missed = load(known_rows, row + APART), load(known_rows, row + RESIDUAL) > REACHED
    return (load(known_rows, row + DETERMINED) <= HARDLY_DETERMINED) | (missed & (apart >= COMPLEX))


@kernel
def doubts(known_rows, row):
    """Whether a branch is real with an angle undetermined, whether an angle is, and whether it coincides with another."""
    real, hardly = load(known_rows, row + RESIDUAL) <= REACHED, is_in_doubt(known_rows, row)
    return real & hardly, hardly, real & (load(known_rows, row + APART) <= COINCIDING)


@kernel
def proof_of_lanes(known_rows):
    """What the branches of one target prove, if each is in a lane of its own; see ``proof_of``."""
    free_real, free, coincide = doubts(known_rows, 0)
    if any_lane(free_real):
        return CONTINUUM
    if any_lane(free):
        return UNPROVED
    return COINCIDE if any_lane(coincide) else COMPLETE


@kernel
def proof_of(known_rows):
    """What the branches of a target prove (``closed_form_layout``).

    If an unsolved branch has an undetermined angle, another value may solve it: no proof.
    """
    like = load(known_rows, RESIDUAL)
    free_real, free, coincide = 0.0 * like, 0.0 * like, 0.0 * like
    for branch in range(known_rows.shape[0] // N_KNOWN):
        of_it = doubts(known_rows, N_KNOWN * branch)
        free_real, free = where(of_it[0], 1.0, free_real), where(of_it[1], 1.0, free)
        coincide = where(of_it[2], 1.0, coincide)
    some = where(coincide > 0.0, COINCIDE * 1.0, COMPLETE * 1.0)
    return where(free_real > 0.0, CONTINUUM * 1.0, where(free > 0.0, UNPROVED * 1.0, some))
