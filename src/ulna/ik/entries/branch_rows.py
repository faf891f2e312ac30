"""Allocates and fills the rows of a closed form's branches, and polishes the branches."""

import numpy as np

from ulna.engine.decorators import kernel, workspace
from ulna.engine.lanes import WIDTH, any_lane, load, splat, sqrt, store, where, zero_rows
from ulna.kernels.chain.closed_form_layout import (
    COINCIDE,
    COLUMNS,
    COMPLEX,
    ENOUGH,
    FORM,
    INVERSE_REACH,
    MAX_ERROR,
    MIN_ERROR,
    N_BOUNDS,
    N_KNOWN,
    POLISH,
    REACHED,
    RESIDUAL,
    SEPARATION,
    SIGNS,
    STEPS,
)
from ulna.kernels.chain.closed_form_rows import proof_of
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import error_squares, pose_error
from ulna.kernels.ik.nearest_branch import clip_branch, is_hardly_beyond, polish
from ulna.kernels.ik.search_layout import N_SYSTEM
from ulna.kernels.spatial.elementary import maximum, sincos
from ulna.kernels.spatial.se3 import load_pose

N_AXES = 6
_STEPS_AT_LIMITS = 16  # of a polish: near two singularities at once the steps are short


@workspace
def branch_state(n):
    """Rows of signs, free angles, target, q and properties for n^3 branches; and a polish's scratch."""
    branches = n * n * n
    target, q, known = 3 * n + 2 * N_AXES, 3 * n + 2 * N_AXES + 12, 3 * n + 2 * N_AXES + 12 + N_AXES * branches
    jacobian = known + N_KNOWN * branches
    system = jacobian + 6 * N_AXES
    block = zero_rows(system + N_SYSTEM + N_AXES)
    for k in range(3 * n):
        for lane in range(WIDTH):
            bit = (lane >> (2 - k)) & 1 if n == 1 else k & 1
            block[k, lane] = 1.0 - 2.0 * bit
    block[target - N_AXES : target] = 1.0  # the cosines of free angles
    rows = block[: 3 * n], block[3 * n : target], block[target:q], block[q:known], block[known:jacobian]
    return rows, (block[jacobian:system], block[system : system + N_SYSTEM], block[system + N_SYSTEM :])


@kernel
def write_free_angles(table, angle_rows, free_rows):
    """Write the sines and cosines of the seed's angles about the axes. angle_rows: q, six."""
    for j in range(N_AXES):
        sign = table[SIGNS + j // 3, j % 3]
        s, c = sincos(load(angle_rows, int(table[COLUMNS + j // 3, j % 3])) * sign)
        store(free_rows, j, s)
        store(free_rows, N_AXES + j, c)


@workspace
def polish_branches(table, chain, rows, scratch):
    """Polish the branches in the rows of ``branch_state``."""
    _, _, target_rows, q_rows, known_rows = rows
    min_error, max_error, steps = table[POLISH, MIN_ERROR], table[POLISH, MAX_ERROR], int(table[POLISH, STEPS])
    for k in range(q_rows.shape[0] // N_AXES):
        error = maximum(load(known_rows, N_KNOWN * k), min_error)
        if min_error == 0.0:  # a certainly complex branch has no solution: Newton steps would lead to another branch's solution
            complex_ = (load(known_rows, N_KNOWN * k + SEPARATION) < COMPLEX) & (error > REACHED)
            error = where(complex_, maximum(error, 2.0 * max_error), error)
        store(known_rows, N_KNOWN * k, error)
        if any_lane((error > ENOUGH) & (error <= max_error)):
            branch, known = q_rows[N_AXES * k : N_AXES * (k + 1)], known_rows[N_KNOWN * k : N_KNOWN * (k + 1)]
            polish(chain, (target_rows, branch, known, known_rows[:0]), table[FORM, INVERSE_REACH], max_error, steps, scratch)


@workspace
def move_to_limits(table, chain, rows, scratch, seed, room):
    """Put joints hardly beyond a limit at the limit, if the branch still reaches the target there.

    The allowed excess depends on the accuracy of the angle. Near the singularity of a wrist, a rounding eps of the pose rotates
    two joints against each other by eps / |sin q_5|. So the other joints follow the joint to its limit, and the error there
    decides. ``is_any_hardly_beyond`` takes less time to find whether there are any. seed: The rows of the seed and of the bounds
    of ``nearest_branch``. room: Six rows for q, and one for the error.
    """
    (_, _, target_rows, q_rows, known_rows), (seed_rows, bound_rows), (inside_rows, error_rows) = rows, seed, room
    n_limits = 2 * (bound_rows.shape[0] // N_BOUNDS)
    for k in range(q_rows.shape[0] // N_AXES):
        branch, residual = q_rows[N_AXES * k : N_AXES * (k + 1)], load(known_rows, N_KNOWN * k + RESIDUAL)
        is_beyond = is_hardly_beyond(q_rows, known_rows, k, bound_rows)
        if any_lane(is_beyond):
            clip_branch(branch, seed_rows, bound_rows, inside_rows)
            store(error_rows, 0, where(is_beyond, 1.0, 0.0 * residual))
            polished = target_rows, inside_rows, error_rows, bound_rows[:n_limits]
            polish(chain, polished, table[FORM, INVERSE_REACH], np.inf, _STEPS_AT_LIMITS, scratch)
            is_moved = is_beyond & (load(error_rows, 0) <= maximum(residual, ENOUGH))
            for j in range(N_AXES):
                store(branch, j, where(is_moved, load(inside_rows, j), load(branch, j)))


@workspace
def polish_seed(table, chain, rows, scratch, seed, one_target):
    """Polish the seeds too, if they may lead to a nearer branch than the known ones; False if none may.

    This is possible for axes that are only nearly of the family, since a polished branch need not be the nearest one. It is also
    possible for undetermined angles. seed: Six rows; six for q, output; N_KNOWN, whose residual is output, infinite for a seed
    that is not polished. one_target: Whether the lanes are the branches of one target.
    """
    seed_rows, q_rows, known_rows = seed
    like, max_error = load(seed_rows, 0), table[POLISH, MAX_ERROR]
    is_needed = splat(1.0, like) > 0.0
    if table[POLISH, MIN_ERROR] == 0.0:
        is_needed = proof_of(rows[4]) > COINCIDE
        if not any_lane(is_needed):
            return False
        if one_target:
            is_needed = splat(1.0, like) > 0.0
    for j in range(N_AXES):
        store(q_rows, j, load(seed_rows, j))
    p2, r2 = error_squares(pose_error(chain_pose(chain, q_rows), load_pose(rows[2], 0)))
    error = sqrt(p2 * table[FORM, INVERSE_REACH] ** 2 + r2)
    is_near = is_needed & (error <= max_error)
    store(known_rows, RESIDUAL, where(is_near, error, np.inf))
    if not any_lane(is_near):
        return False
    polished = rows[2], q_rows, known_rows[:1], known_rows[:0]
    polish(chain, polished, table[FORM, INVERSE_REACH], max_error, int(table[POLISH, STEPS]), scratch)
    return True


@workspace
def polish_state(n_dof, bounds):
    """Rows of the target, q, the error, bounds, a Jacobian, the last q, and the scratch of a polish."""
    n_bounds = bounds.shape[0]
    q, error, bound, jacobian, last = 12, 12 + n_dof, 13 + n_dof, 13 + n_dof + n_bounds, 13 + 7 * n_dof + n_bounds
    block = zero_rows(last + n_dof + N_SYSTEM)
    for k in range(n_bounds):
        block[bound + k, :] = bounds[k]
    return (
        block[:q],
        block[q:error],
        block[error:bound],
        block[bound:jacobian],
        block[jacobian:last],
        block[last : last + n_dof],
        block[last + n_dof :],
    )


@kernel
def write_seed(seed, seed_rows):
    """Write a seed (6,) to all lanes."""
    for j in range(N_AXES):
        for lane in range(WIDTH):
            seed_rows[j, lane] = seed[j]
