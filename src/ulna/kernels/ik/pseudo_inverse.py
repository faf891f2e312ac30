"""Computes the step of the pseudo-inverse, dq = J^+ e.

It is the shortest of all steps that would reach the target if the arm were linear.

Source: Whitney (IEEE Trans. Man-Machine Systems 1969); the singular values by one-sided rotations: Hestenes (J. SIAM 1958), with
the angle of Rutishauser as in Golub and Van Loan, Matrix Computations (4th ed.), section 8.6.3.

1. Turn pairs of rows of [J | e] until all rows of J are square to each other: U' J = S V', U' e. A row's length is then a
   singular value sigma, its direction the v that belongs to it.
2. dq = sum of v (U' e) / sigma over all sigma above CUTOFF times the largest: smaller ones are directions in which the arm
   cannot move, and would ask for enormous steps.
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import load, splat, sqrt, store, where
from ulna.kernels.spatial.elementary import maximum

CUTOFF = 1e-4
SWEEPS = 8  # of all fifteen pairs; six are usual
_SQUARE = 1e-30  # of the product of two rows' squares: below it they count as square to each other


@routine
def pseudo_inverse_step(jacobian_rows, n_dof, error_rows, step_rows):
    """Write J^+ e; both J and the six error rows are overwritten."""
    for _ in range(SWEEPS):
        for p in range(5):
            for r in range(p + 1, 6):
                orthogonalise(jacobian_rows, n_dof, error_rows, p, r)
    largest = splat(0.0, load(error_rows, 0))
    for k in range(6):
        largest = maximum(largest, dot_rows(jacobian_rows, n_dof, k, k))
    for j in range(n_dof):
        store(step_rows, j, splat(0.0, largest))
    for k in range(6):
        square = dot_rows(jacobian_rows, n_dof, k, k)
        usable = square > CUTOFF**2 * largest
        share = where(usable, load(error_rows, k) / where(usable, square, 1.0), 0.0)
        for j in range(n_dof):
            store(step_rows, j, load(step_rows, j) + share * load(jacobian_rows, 6 * j + k))


@kernel
def orthogonalise(jacobian_rows, n_dof, error_rows, p, r):
    """Turn rows p and r of [J | e] by the angle that makes those of J square to each other."""
    cosine, sine = jacobi_rotation(jacobian_rows, n_dof, p, r)
    rotate_rows(error_rows, p, r, cosine, sine)
    for j in range(n_dof):
        rotate_rows(jacobian_rows, 6 * j + p, 6 * j + r, cosine, sine)


@kernel
def jacobi_rotation(jacobian_rows, n_dof, p, r):
    """Cosine and sine of the angle that makes rows p and r of J square to each other."""
    a, b, c = dot_rows(jacobian_rows, n_dof, p, p), dot_rows(jacobian_rows, n_dof, r, r), dot_rows(jacobian_rows, n_dof, p, r)
    needed = c * c > _SQUARE * a * b
    zeta = (b - a) / (2.0 * where(needed, c, 1.0))
    t = where(zeta >= 0.0, 1.0, -1.0) / (abs(zeta) + sqrt(1.0 + zeta * zeta))
    t = where(needed, t, 0.0)
    cosine = 1.0 / sqrt(1.0 + t * t)
    return cosine, cosine * t


@kernel
def rotate_rows(rows, p, r, cosine, sine):
    """Rows p and r turned by an angle."""
    x, y = load(rows, p), load(rows, r)
    store(rows, p, cosine * x - sine * y)
    store(rows, r, sine * x + cosine * y)


@kernel
def dot_rows(jacobian_rows, n_dof, p, r):
    """The product of rows p and r of J."""
    total = load(jacobian_rows, p) * load(jacobian_rows, r)
    for j in range(1, n_dof):
        total = total + load(jacobian_rows, 6 * j + p) * load(jacobian_rows, 6 * j + r)
    return total
