"""Writes the data of an IK search to a lane, and copies the search's result from the lane."""

import numpy as np

from ulna.engine.decorators import kernel, routine, workspace
from ulna.engine.lanes import sqrt, store, zero_rows
from ulna.kernels.ik.damped_system import store_six
from ulna.kernels.ik.levenberg_marquardt import (
    ALLOWED,
    CHANGE,
    ENDED,
    ERROR,
    HAS_SOLVED,
    LAMBDA,
    LAST_ERROR,
    N_STATE,
    P2,
    R2,
    RUNNING,
    TAKEN,
)
from ulna.kernels.ik.search_layout import N_SYSTEM, NOT_FOUND, SOLVED
from ulna.kernels.spatial.vectors import rotate_inverse

LOWER, UPPER, LOW, HIGH = 0, 1, 2, 3  # rows of the bounds: the bounds of q, and the range of starts


@workspace
def search_state(n_dof):
    """The rows of eight searches, and the scratch of a step (``levenberg_marquardt``), cut from one block."""
    target, bound, state = 2 * n_dof, 2 * n_dof + 12, 4 * n_dof + 12
    jacobian = state + N_STATE
    system = jacobian + 6 * n_dof
    block = zero_rows(system + N_SYSTEM)
    rows = block[:n_dof], block[n_dof:target], block[target:bound], block[bound:state], block[state:jacobian]
    return rows, (block[jacobian:system], block[system:])


@kernel
def write_target(target, target_rows, lane):
    """Write a pose of twelve numbers to a lane."""
    for k in range(12):
        target_rows[k, lane] = target[k]


@kernel
def write_bounds(box, bound_rows, lane):
    """Write the bounds to a lane."""
    n_dof = box.shape[1]
    for j in range(n_dof):
        bound_rows[j, lane], bound_rows[n_dof + j, lane] = box[LOWER, j], box[UPPER, j]


@kernel
def write_start(box, seed, samples, start, q_rows, lane):
    """Write a start to a lane; an entry whose sample is NaN keeps the seed's value."""
    for j in range(seed.shape[0]):
        sample = samples[start, j]
        x = box[LOW, j] + sample * (box[HIGH, j] - box[LOW, j]) if sample >= 0.0 else seed[j]
        q_rows[j, lane] = min(max(x, box[LOWER, j]), box[UPPER, j])


@kernel
def reset_state(state_rows, allowed, with_posture, lane):
    """Write the state of a lane before its first step."""
    state_rows[ENDED, lane], state_rows[LAST_ERROR, lane] = RUNNING, np.inf
    state_rows[P2, lane], state_rows[R2, lane] = np.inf, np.inf
    state_rows[TAKEN, lane], state_rows[ALLOWED, lane] = 0.0, allowed
    state_rows[CHANGE, lane] = np.inf if with_posture else 0.0


@kernel
def store_state(state_rows, ended, p2, r2, steps, e):
    """Write the state of all lanes after a number of steps: outcome, squared errors, pose error."""
    store(state_rows, ENDED, ended)
    store(state_rows, P2, p2)
    store(state_rows, R2, r2)
    store(state_rows, TAKEN, steps + 1.0)
    store_six(state_rows, ERROR, e)


@routine
def write_result(rows, lane, start, row, q_out, info):
    """Write the result of a lane to a row of q_out and of info.

    rows: Those of q, the target and the state.
    """
    q_rows, target_rows, state_rows = rows
    for j in range(q_out.shape[1]):
        q_out[row, j] = q_rows[j, lane]
    e = (
        state_rows[ERROR, lane], state_rows[ERROR + 1, lane], state_rows[ERROR + 2, lane],
        state_rows[ERROR + 3, lane], state_rows[ERROR + 4, lane], state_rows[ERROR + 5, lane],
    )  # fmt: skip
    target = (
        target_rows[0, lane], target_rows[1, lane], target_rows[2, lane], 0.0,
        target_rows[4, lane], target_rows[5, lane], target_rows[6, lane], 0.0,
        target_rows[8, lane], target_rows[9, lane], target_rows[10, lane], 0.0,
    )  # fmt: skip
    v, w = rotate_inverse(target, (e[0], e[1], e[2])), rotate_inverse(target, (e[3], e[4], e[5]))
    found = info[row]
    found.status = SOLVED if state_rows[ENDED, lane] == HAS_SOLVED else NOT_FOUND
    found.iterations, found.start, found.damping = int(state_rows[TAKEN, lane]) - 1, start, state_rows[LAMBDA, lane]
    found.residual_square = state_rows[P2, lane] + state_rows[R2, lane]
    found.position_error = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    found.rotation_error = sqrt(e[3] * e[3] + e[4] * e[4] + e[5] * e[5])
    for k in range(3):
        found.residual[k], found.residual[3 + k] = v[k], w[k]
