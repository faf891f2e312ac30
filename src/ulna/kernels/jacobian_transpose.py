"""Inverse kinematics by Jacobian transpose: steepest descent on the squared pose error, kept within the joint limits.

Source: Wolovich and Elliott (CDC 1984); the step length is Buss's (Introduction to Inverse Kinematics, 2004, eq. 7).

1. With the error e = (displacement, rotation vector) and J at q, the direction of steepest descent of |e|^2 / 2 is g = J' e;
   the entries that would push a joint through its limit are left out.
2. Along g, J g is the change of the pose; the step alpha = <e, J g> / <J g, J g> would meet the target best if the arm were
   linear.
3. Try q + s alpha g, kept within the limits. If the error falls, go there and set s = 1; if not, stay and halve s. So the error
   never rises.
4. Done at the tolerances. Stationary when no direction is left or s is too small to move: a local minimum, or a singularity.
"""

import numpy as np

from ulna.kernels.block import gather
from ulna.kernels.chain import chain_pose
from ulna.kernels.compile import entry, kernel
from ulna.kernels.damped_step import add_column, error_squares, gradient, pose_error, release_pressed, within_limits
from ulna.kernels.jacobian import BASE, chain_jacobian
from ulna.kernels.lanes import WIDTH, any_lane, load, splat, store, where
from ulna.kernels.layout import LARGEST_DEFECT
from ulna.kernels.se3 import load_pose, rigidity_defect
from ulna.kernels.search_layout import (
    ITERATIONS,
    MAX_ITERATIONS,
    NOT_A_POSE,
    NOT_FOUND,
    POSITION_ERROR,
    POSITION_TOLERANCE,
    ROTATION_ERROR,
    ROTATION_TOLERANCE,
    SOLVED,
    STATIONARY,
    STATUS,
)

_LEAST_SCALE = 1e-9


@kernel
def descend(chain, limits, target_rows, settings, q_rows, trial_rows, axis_rows, jacobian_rows, info_rows):
    """Steps 1 to 4 for every lane, until all have ended. The columns of the information are rows here."""
    target = load_pose(target_rows, 0)
    scale = splat(1.0, load(q_rows, 0))
    p2, r2 = error_squares(pose_error(chain_pose(chain, q_rows), target))
    least = p2 + r2  # carried along: evaluated again at the same q in another way, it would round differently
    iterations, steps, moving = splat(0.0, scale), 0, True
    while moving:
        e = pose_error(chain_jacobian(chain, q_rows, BASE, axis_rows, jacobian_rows), target)
        p2, r2 = error_squares(e)
        solved = (p2 <= settings[POSITION_TOLERANCE] ** 2) & (r2 <= settings[ROTATION_TOLERANCE] ** 2)
        release_pressed(limits, q_rows, e, jacobian_rows)
        length = step_length(jacobian_rows, limits.shape[1], e)
        stationary = (scale < _LEAST_SCALE) | (length <= 0.0)
        active = where(solved | stationary, 0.0, 1.0)
        store(info_rows, STATUS, where(solved, SOLVED, where(stationary, STATIONARY, NOT_FOUND)))
        store(info_rows, POSITION_ERROR, p2)
        store(info_rows, ROTATION_ERROR, r2)
        moving = any_lane(active > 0.0) and steps < settings[MAX_ITERATIONS]
        if moving:
            for j in range(limits.shape[1]):
                moved = load(q_rows, j) + scale * length * gradient(jacobian_rows, j, e)
                store(trial_rows, j, within_limits(moved, limits, j))
            new_p2, new_r2 = error_squares(pose_error(chain_pose(chain, trial_rows), target))
            better = (new_p2 + new_r2 < least) & (active > 0.0)
            for j in range(limits.shape[1]):
                store(q_rows, j, where(better, load(trial_rows, j), load(q_rows, j)))
            least = where(better, new_p2 + new_r2, least)
            scale = where(better, 1.0, 0.5 * scale)
            iterations = iterations + active
            steps += 1
    store(info_rows, ITERATIONS, iterations)


@kernel
def step_length(jacobian_rows, n_dof, e):
    """<e, J g> / <J g, J g> for g = J' e; 0 where g is."""
    zero = splat(0.0, e[0])
    v = zero, zero, zero, zero, zero, zero
    for j in range(n_dof):
        v = add_column(v, jacobian_rows, j, gradient(jacobian_rows, j, e))
    along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2] + e[3] * v[3] + e[4] * v[4] + e[5] * v[5]
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3] + v[4] * v[4] + v[5] * v[5]
    return where(square > 0.0, along / where(square > 0.0, square, 1.0), 0.0)


@entry
def transpose_each(chain, limits, seeds, targets, settings, q_out, info):
    """Solve for each target of shape (n, 4, 4) from its seed: a target a lane. The arrays are those of ``solve_each``."""
    n, n_dof = q_out.shape
    q_rows, trial_rows = np.zeros((max(1, n_dof), WIDTH)), np.zeros((max(1, n_dof), WIDTH))
    axis_rows, jacobian_rows = np.empty((6 * chain.shape[0], WIDTH)), np.empty((6 * n_dof, WIDTH))
    target_rows, info_rows = np.empty((12, WIDTH)), np.empty((info.shape[1], WIDTH))
    for start in range(0, n, WIDTH):
        gather(seeds, start, q_rows)
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            for k in range(12):
                target_rows[k, lane] = targets[i, k // 4, k % 4]
        descend(chain, limits, target_rows, settings, q_rows, trial_rows, axis_rows, jacobian_rows, info_rows)
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            for j in range(n_dof):
                q_out[i, j] = q_rows[j, lane]
            info[i, STATUS], info[i, ITERATIONS] = info_rows[STATUS, lane], info_rows[ITERATIONS, lane]
            info[i, POSITION_ERROR] = np.sqrt(info_rows[POSITION_ERROR, lane])
            info[i, ROTATION_ERROR] = np.sqrt(info_rows[ROTATION_ERROR, lane])
            if not rigidity_defect(targets[i]) <= LARGEST_DEFECT:
                info[i, STATUS] = NOT_A_POSE
