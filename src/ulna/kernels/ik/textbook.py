"""Computes one step of each textbook method: Jacobian transpose, damped least squares and pseudo-inverse.

With the error e and the Jacobian J at q, the step dq is

1. ``jacobian_transpose``: alpha g with g = J' e, the direction of steepest descent of |e|^2 / 2. J g is the change of the pose
   along it, so alpha = <e, J g> / <J g, J g> would come nearest to the target if the arm were linear. Wolovich and Elliott (CDC
   1984); the step length is Buss's (Introduction to Inverse Kinematics, 2004, eq. 7).
2. ``damped_least_squares``: J' (J J' + lambda I)^-1 e, which minimises |J dq - e|^2 + lambda |dq|^2: near a singularity, where an
   undamped step would be enormous, the second term keeps it short. Away from one it costs a share lambda / sigma^2 of the error
   at each step, so the error falls by a factor and not quadratically. Levenberg-Marquardt reduces lambda with the error. Wampler
   (IEEE Trans. Systems, Man and Cybernetics 1986); Nakamura and Hanafusa (J. Dyn. Sys., Meas., Control 1986).
3. ``pseudo_inverse``: J^+ e = sum of v (u' e) / sigma over all singular values above CUTOFF times the largest: smaller ones are
   directions in which the arm cannot move, and would need enormous steps. It is the shortest of all steps that would reach the
   target if the arm were linear. Whitney (IEEE Trans. Man-Machine Systems 1969).
"""

from ulna.engine.decorators import kernel, routine
from ulna.engine.lanes import load, splat, store, where
from ulna.kernels.ik.damped_system import add_column, column_dot, error_squares, pose_error, solve_damped, store_six
from ulna.kernels.ik.search_layout import DAMPED_LEAST_SQUARES, JACOBIAN_TRANSPOSE, TASK, WHOLE_POSE
from ulna.kernels.ik.singular_values import SWEEPS, dot_rows, jacobi_rotation, rotate_rows
from ulna.kernels.ik.task_error import task_error
from ulna.kernels.spatial.elementary import maximum

DAMPING = 0.01  # lambda of damped least squares
CUTOFF = 1e-4


@kernel
def take_step(method, jacobian_rows, n_dof, e, system_rows, error_rows, step_rows):
    """Write the step of the method, shape (n_dof,)."""
    if method == JACOBIAN_TRANSPOSE:
        transpose_step(jacobian_rows, n_dof, e, step_rows)
    elif method == DAMPED_LEAST_SQUARES:
        damped_step(jacobian_rows, n_dof, e, system_rows, step_rows)
    else:
        store_six(error_rows, 0, e)
        pseudo_inverse_step(jacobian_rows, n_dof, error_rows, step_rows)


@kernel
def task_squares(settings, pose, target, spare_rows):
    """The squares of the error that the task counts; spare_rows: a Jacobian that may be overwritten."""
    e = pose_error(pose, target)
    if int(settings[TASK]) != WHOLE_POSE:
        e = task_error(settings, pose, target, e, spare_rows)
    return error_squares(e)


@kernel
def largest_entry(step_rows):
    """The largest size of an entry of a step."""
    largest = abs(load(step_rows, 0))
    for j in range(1, step_rows.shape[0]):
        largest = maximum(largest, abs(load(step_rows, j)))
    return largest


@kernel
def transpose_step(jacobian_rows, n_dof, e, step_rows):
    """Write alpha g, entry by entry of q."""
    alpha = step_length(jacobian_rows, n_dof, e)
    for j in range(n_dof):
        store(step_rows, j, alpha * column_dot(jacobian_rows, j, e))


@kernel
def step_length(jacobian_rows, n_dof, e):
    """<e, J g> / <J g, J g> for g = J' e; 0 where g is."""
    zero = splat(0.0, e[0])
    v = zero, zero, zero, zero, zero, zero
    for j in range(n_dof):
        v = add_column(v, jacobian_rows, j, column_dot(jacobian_rows, j, e))
    along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2] + e[3] * v[3] + e[4] * v[4] + e[5] * v[5]
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3] + v[4] * v[4] + v[5] * v[5]
    return where(square > 0.0, along / where(square > 0.0, square, 1.0), 0.0)


@kernel
def damped_step(jacobian_rows, n_dof, e, system_rows, step_rows):
    """Write J' (J J' + lambda I)^-1 e."""
    y = solve_damped(jacobian_rows, n_dof, splat(DAMPING, e[0]), e, system_rows)
    for j in range(n_dof):
        store(step_rows, j, column_dot(jacobian_rows, j, y))


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
    """Turn rows p and r of [J | e] by the angle that makes those of J orthogonal."""
    cosine, sine = jacobi_rotation(jacobian_rows, n_dof, p, r)
    rotate_rows(error_rows, p, r, cosine, sine)
    for j in range(n_dof):
        rotate_rows(jacobian_rows, 6 * j + p, 6 * j + r, cosine, sine)
