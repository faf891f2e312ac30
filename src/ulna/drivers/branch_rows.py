"""Makes and fills the rows of the branches of a closed form, and polishes these. Used by ``drivers``."""

import numpy as np

from ulna.engine.decorators import kernel, workspace
from ulna.engine.lanes import any_lane, load, store, where
from ulna.engine.width import WIDTH
from ulna.kernels.chain.closed_form_layout import (
    APART,
    COLUMNS,
    COMPLEX,
    FORM,
    INVERSE_REACH,
    LEAST_ERROR,
    MOST_ERROR,
    N_KNOWN,
    POLISH,
    REACHED,
    SIGNS,
    STEPS,
)
from ulna.kernels.ik.polish import ENOUGH, polish
from ulna.kernels.ik.scratch_layout import N_SYSTEM
from ulna.kernels.spatial.elementary import maximum, sincos

N_AXES = 6


@workspace
def branch_state(n):
    """Rows of signs, free angles, the target, q and what is known, for n^3 branches; and the scratch of a polish."""
    branches = n * n * n
    target, q, known = 3 * n + 2 * N_AXES, 3 * n + 2 * N_AXES + 12, 3 * n + 2 * N_AXES + 12 + N_AXES * branches
    jacobian = known + N_KNOWN * branches
    system = jacobian + 6 * N_AXES
    block = np.zeros((system + N_SYSTEM + N_AXES, WIDTH))
    for k in range(3 * n):
        for lane in range(WIDTH):
            bit = (lane >> (2 - k)) & 1 if n == 1 else k & 1
            block[k, lane] = 1.0 - 2.0 * bit
    block[target - N_AXES : target] = 1.0  # the cosines of free angles
    rows = block[: 3 * n], block[3 * n : target], block[target:q], block[q:known], block[known:jacobian]
    return rows, (block[jacobian:system], block[system : system + N_SYSTEM], block[system + N_SYSTEM :])


@kernel
def write_free_angles(table, angle_rows, free_rows):
    """Write the sines and cosines of the angles about the axes that a seed gives. angle_rows: q, six."""
    for j in range(N_AXES):
        sign = table[SIGNS + j // 3, j % 3]
        s, c = sincos(load(angle_rows, int(table[COLUMNS + j // 3, j % 3])) * sign)
        store(free_rows, j, s)
        store(free_rows, N_AXES + j, c)


@workspace
def polish_branches(table, chain, rows, scratch):
    """Polish the branches of the rows of ``branch_state``."""
    _, _, target_rows, q_rows, known_rows = rows
    jacobian_rows, system_rows, last_rows = scratch
    least, most, steps = table[POLISH, LEAST_ERROR], table[POLISH, MOST_ERROR], int(table[POLISH, STEPS])
    for k in range(q_rows.shape[0] // N_AXES):
        error = maximum(load(known_rows, N_KNOWN * k), least)
        if least == 0.0:  # a branch that is clearly complex has no solution: Newton steps would lead to that of another
            complex_ = (load(known_rows, N_KNOWN * k + APART) < COMPLEX) & (error > REACHED)
            error = where(complex_, maximum(error, 2.0 * most), error)
        store(known_rows, N_KNOWN * k, error)
        if any_lane((error > ENOUGH) & (error <= most)):
            polish(
                chain, target_rows, q_rows[N_AXES * k : N_AXES * (k + 1)], known_rows[N_KNOWN * k : N_KNOWN * (k + 1)],
                table[FORM, INVERSE_REACH], most, steps, jacobian_rows, system_rows, last_rows,
            )  # fmt: skip


@workspace
def polish_state(n_dof):
    """Rows of the target, q, the errors, a Jacobian, the last q, and the scratch of a polish."""
    block = np.zeros((13 + 8 * n_dof + N_SYSTEM, WIDTH))
    q, error, jacobian, last = 12, 12 + n_dof, 13 + n_dof, 13 + 7 * n_dof
    return (
        block[:q],
        block[q:error],
        block[error:jacobian],
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
