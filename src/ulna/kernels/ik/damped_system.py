"""Computes pose errors, solves the damped 6x6 system and keeps joints within bounds.

Source: Levenberg (1944), Marquardt (1963); Wampler (1986) and Nakamura and Hanafusa (1986) for arms; Sugihara (IEEE Trans.
Robotics 2011) for a damping in proportion to the squared error.
"""

from ulna.engine.decorators import kernel
from ulna.engine.lanes import load, sqrt, store, where
from ulna.kernels.spatial.elementary import maximum, minimum
from ulna.kernels.spatial.se3 import rotation_between


@kernel
def pose_error(pose, target):
    """The error from pose to target: displacement [m] and rotation vector [rad], in the axes of the base."""
    wx, wy, wz = rotation_between(pose, target)
    return target[3] - pose[3], target[7] - pose[7], target[11] - pose[11], wx, wy, wz


@kernel
def error_squares(e):
    """|displacement|^2 and |rotation|^2 of a pose error."""
    return e[0] * e[0] + e[1] * e[1] + e[2] * e[2], e[3] * e[3] + e[4] * e[4] + e[5] * e[5]


@kernel
def column_dot(jacobian_rows, j, e):
    """Entry j of J' e: the inner product of its column and six numbers."""
    total = load(jacobian_rows, 6 * j) * e[0]
    for k in range(1, 6):
        total = total + load(jacobian_rows, 6 * j + k) * e[k]
    return total


@kernel
def add_column(v, jacobian_rows, j, rate):
    """The six numbers v + J_j rate: v plus the contribution of entry j of q."""
    return (
        v[0] + load(jacobian_rows, 6 * j) * rate,
        v[1] + load(jacobian_rows, 6 * j + 1) * rate,
        v[2] + load(jacobian_rows, 6 * j + 2) * rate,
        v[3] + load(jacobian_rows, 6 * j + 3) * rate,
        v[4] + load(jacobian_rows, 6 * j + 4) * rate,
        v[5] + load(jacobian_rows, 6 * j + 5) * rate,
    )


@kernel
def load_six(rows, i):
    """Six rows from row i on."""
    return load(rows, i), load(rows, i + 1), load(rows, i + 2), load(rows, i + 3), load(rows, i + 4), load(rows, i + 5)


@kernel
def store_six(rows, i, v):
    """Write six numbers to the rows from row i on."""
    for k in range(6):
        store(rows, i + k, v[k])


@kernel
def block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows):
    """Zero the column of every joint at a bound that the error would push beyond it.

    bound_rows: The lower bounds of all entries of q, then the upper ones.
    """
    n_dof = bound_rows.shape[0] // 2
    for j in range(n_dof):
        q, push = load(q_rows, j), column_dot(jacobian_rows, j, e)
        pressed = ((q <= load(bound_rows, j)) & (push < 0.0)) | ((q >= load(bound_rows, n_dof + j)) & (push > 0.0))
        for k in range(6):
            store(jacobian_rows, 6 * j + k, where(pressed, 0.0, load(jacobian_rows, 6 * j + k)))


@kernel
def solve_damped(jacobian_rows, n_dof, damping, e, system_rows):
    """Solve (J J' + damping I) y = e for six numbers by Cholesky; system_rows[21:27] also gets y."""
    damped_gram(jacobian_rows, n_dof, damping, system_rows)
    factorize(system_rows)
    substitute(e, system_rows)
    return load_six(system_rows, 21)


@kernel
def damped_gram(jacobian_rows, n_dof, damping, system_rows):
    """Write the lower triangle of J J' + damping I to rows.

    Entry (r, c) goes to row ``r (r + 1) / 2 + c``.
    """
    for r in range(6):
        for c in range(r + 1):
            total = load(jacobian_rows, r) * load(jacobian_rows, c)
            for j in range(1, n_dof):
                total = total + load(jacobian_rows, 6 * j + r) * load(jacobian_rows, 6 * j + c)
            store(system_rows, r * (r + 1) // 2 + c, total + damping if r == c else total)


@kernel
def factorize(system_rows):
    """Replace the lower triangle by its Cholesky factor L, with the reciprocals of the diagonal on the diagonal."""
    for r in range(6):
        for c in range(r + 1):
            total = load(system_rows, r * (r + 1) // 2 + c)
            for k in range(c):
                total = total - load(system_rows, r * (r + 1) // 2 + k) * load(system_rows, c * (c + 1) // 2 + k)
            if r == c:
                store(system_rows, r * (r + 1) // 2 + c, 1.0 / sqrt(total))
            else:
                store(system_rows, r * (r + 1) // 2 + c, total * load(system_rows, c * (c + 1) // 2 + c))


@kernel
def substitute(e, system_rows):
    """Solve L z = e, then L' y = z, in system_rows[21:27]."""
    for r in range(6):
        total = e[r]
        for k in range(r):
            total = total - load(system_rows, r * (r + 1) // 2 + k) * load(system_rows, 21 + k)
        store(system_rows, 21 + r, total * load(system_rows, r * (r + 1) // 2 + r))
    for s in range(6):
        r = 5 - s
        total = load(system_rows, 21 + r)
        for k in range(r + 1, 6):
            total = total - load(system_rows, k * (k + 1) // 2 + r) * load(system_rows, 21 + k)
        store(system_rows, 21 + r, total * load(system_rows, r * (r + 1) // 2 + r))


@kernel
def within_bounds(x, bound_rows, j):
    """x, clipped to the bounds of entry j of q."""
    return minimum(maximum(x, load(bound_rows, j)), load(bound_rows, bound_rows.shape[0] // 2 + j))
