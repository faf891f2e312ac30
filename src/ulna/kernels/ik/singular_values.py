"""Solves damped least squares by singular values, for very small damping.

lambda is added to each sigma^2 separately. In J J' + lambda I it would be lost to rounding.

1. Rotate pairs of rows of [J | e | I] until all rows of J are orthogonal: U' J = S V', U' e, U'. The length of a row is then a
   singular value sigma, and its direction the right singular vector v.
2. x = sum of v sigma / (sigma^2 + lambda) (U' e); e - J x = sum of u lambda / (sigma^2 + lambda) (U' e). This form has a
   small relative error, while the difference e - J x would be rounding alone.
3. A sigma within the rounding of J counts as 0: rounding hides whether the arm can move in its direction.

Source: Nakamura and Hanafusa (J. Dyn. Sys., Meas., Control 1986) for sigma / (sigma^2 + lambda); singular values by one-sided
rotations: Hestenes (J. SIAM 1958), with the angle of Rutishauser as in Golub and Van Loan, Matrix Computations (4th ed.), 8.6.3.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import load, splat, sqrt, store, where
from ulna.kernels.ik.damped_system import store_six

SWEEPS = 8  # of all fifteen pairs; six are usual
_NOISE = 1e-14  # of the square root of the sum of all squares
_SQUARE = 1e-30  # of the product of two rows' squares: below it they count as orthogonal


@routine
def damped_by_singular_values(jacobian_rows, n_dof, damping, e, rotated_rows):
    """The residual e - J x of x = J' (J J' + damping I)^-1 e, six numbers.

    J is overwritten: x is the sum of its six rows weighted by rotated_rows[:6].
    """
    begin_rotation(e, rotated_rows)
    orthogonalize_all(jacobian_rows, n_dof, rotated_rows)
    total = splat(0.0, e[0])
    for k in range(6):
        total = total + dot_rows(jacobian_rows, n_dof, k, k)
    zero = splat(0.0, e[0])
    residual = zero, zero, zero, zero, zero, zero
    for k in range(6):
        square, along = dot_rows(jacobian_rows, n_dof, k, k), load(rotated_rows, k)
        usable = square > _NOISE**2 * total
        share = where(usable, along / where(usable, square + damping, 1.0), 0.0)
        residual = add_rotated(residual, rotated_rows, k, where(usable, share * damping, along))
        store(rotated_rows, k, share)
    return residual


@kernel
def begin_rotation(e, rotated_rows):
    """Write [e | I]."""
    store_six(rotated_rows, 0, e)
    for column in range(6):
        for k in range(6):
            store(rotated_rows, 6 + 6 * column + k, splat(1.0 if k == column else 0.0, e[0]))


@kernel
def orthogonalize_all(jacobian_rows, n_dof, rotated_rows):
    """Step 1, for n_dof columns of J and seven others."""
    for _ in range(SWEEPS):
        for p in range(5):
            for r in range(p + 1, 6):
                cosine, sine = jacobi_rotation(jacobian_rows, n_dof, p, r)
                for j in range(n_dof):
                    rotate_rows(jacobian_rows, 6 * j + p, 6 * j + r, cosine, sine)
                for column in range(7):
                    rotate_rows(rotated_rows, 6 * column + p, 6 * column + r, cosine, sine)


@kernel
def add_rotated(v, rotated_rows, k, rate):
    """The six numbers v + u_k rate."""
    return (
        v[0] + load(rotated_rows, 6 + k) * rate,
        v[1] + load(rotated_rows, 12 + k) * rate,
        v[2] + load(rotated_rows, 18 + k) * rate,
        v[3] + load(rotated_rows, 24 + k) * rate,
        v[4] + load(rotated_rows, 30 + k) * rate,
        v[5] + load(rotated_rows, 36 + k) * rate,
    )


@kernel
def jacobi_rotation(jacobian_rows, n_dof, p, r):
    """Cosine and sine of the angle that makes rows p and r of J orthogonal."""
    a, b, c = dot_rows(jacobian_rows, n_dof, p, p), dot_rows(jacobian_rows, n_dof, r, r), dot_rows(jacobian_rows, n_dof, p, r)
    needed = c * c > _SQUARE * a * b
    zeta = (b - a) / (2.0 * where(needed, c, 1.0))
    t = where(zeta >= 0.0, 1.0, -1.0) / (abs(zeta) + sqrt(1.0 + zeta * zeta))
    t = where(needed, t, 0.0)
    cosine = 1.0 / sqrt(1.0 + t * t)
    return cosine, cosine * t


@kernel
def rotate_rows(rows, p, r, cosine, sine):
    """Rotate rows p and r by an angle."""
    x, y = load(rows, p), load(rows, r)
    store(rows, p, cosine * x - sine * y)
    store(rows, r, sine * x + cosine * y)


@kernel
def dot_rows(jacobian_rows, n_dof, p, r):
    """The inner product of rows p and r of J."""
    total = load(jacobian_rows, p) * load(jacobian_rows, r)
    for j in range(1, n_dof):
        total = total + load(jacobian_rows, 6 * j + p) * load(jacobian_rows, 6 * j + r)
    return total
