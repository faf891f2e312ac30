"""Runs the textbook IK methods from the seed, one target a lane, within the joint bounds.

1. Evaluate the error and the Jacobian, less what the task leaves free; leave out the joints that would be pushed through a
   bound. Done at the tolerances.
2. Take the method's step (``jacobian_transpose``, ``damped_least_squares``, ``pseudo_inverse``), no joint
   further than LARGEST_STEP.
3. The Jacobian transpose takes the step only if the error falls, else it halves the step and tries again (backtracking): so its
   error never rises. The others always take it.
4. Stationary: the step is 0, or too short to move: a local minimum, or a singularity.
"""

import numpy as np

from ulna.drivers.batch import gather
from ulna.drivers.lane_state import search_state, store_state, write_bounds, write_result, write_target
from ulna.engine.decorators import entry, kernel
from ulna.engine.lanes import WIDTH, any_lane, empty_rows, load, splat, store, where
from ulna.engine.signatures import MATRICES, MATRIX, NUMBERS, TABLE, WHOLE
from ulna.kernels.chain.jacobian import chain_jacobian
from ulna.kernels.chain.poses import chain_pose
from ulna.kernels.ik.damped_system import block_joints_at_bounds, error_squares, pose_error, within_bounds
from ulna.kernels.ik.levenberg_marquardt import ENDED, ERROR, HAS_FAILED, HAS_SOLVED, LAMBDA, RUNNING
from ulna.kernels.ik.search_layout import (
    DAMPED_LEAST_SQUARES,
    ITERATIONS,
    JACOBIAN_TRANSPOSE,
    NOT_A_POSE,
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    STATIONARY,
    STATUS,
    STEPS,
    TASK,
    WHOLE_POSE,
)
from ulna.kernels.ik.task_error import task_error
from ulna.kernels.ik.textbook import DAMPING, largest_entry, take_step, task_squares
from ulna.kernels.layout import IN_BASE, LARGEST_DEFECT
from ulna.kernels.spatial.se3 import load_pose, matrix_pose, rigidity_defect

LARGEST_STEP = 1.0  # rad or m
_LEAST_SCALE = 1e-9
_LEAST_STEP = 1e-12
_HAS_STOPPED = 3.0  # how a lane may end here, and in no other search


@kernel
def descend(chain, method, settings, rows, scratch, trace):
    """Steps 1 to 4 for every lane, until all have ended.

    Row k of the trace is lane 0 after k steps: the errors [m, rad], the largest joint step that led there and the damping.
    """
    q_rows, trial_rows, target_rows, bound_rows, state_rows = rows
    jacobian_rows, system_rows, error_rows, step_rows = scratch
    n_dof, target = q_rows.shape[0], load_pose(target_rows, 0)
    scale = splat(1.0, load(q_rows, 0))
    p2, r2 = task_squares(settings, chain_pose(chain, q_rows), target, jacobian_rows)
    least, taken = p2 + r2, splat(0.0, scale)  # least is carried along: evaluated again it would round differently
    steps, moving = 0, True
    while moving:
        pose = chain_jacobian(chain, q_rows, IN_BASE, jacobian_rows, 6, 1)
        e = whole = pose_error(pose, target)
        if int(settings[TASK]) != WHOLE_POSE:
            e = task_error(settings, pose, target, e, jacobian_rows)
        p2, r2 = error_squares(e)
        solved = (p2 <= settings[POSITION_TOLERANCE] ** 2) & (r2 <= settings[ROTATION_TOLERANCE] ** 2)
        block_joints_at_bounds(bound_rows, q_rows, e, jacobian_rows)
        take_step(method, jacobian_rows, n_dof, e, system_rows, error_rows, step_rows)
        size = largest_entry(step_rows)
        stopped = (scale < _LEAST_SCALE) | (size <= (0.0 if method == JACOBIAN_TRANSPOSE else _LEAST_STEP))
        ended = where(solved, HAS_SOLVED, where(stopped, _HAS_STOPPED, RUNNING))
        store_state(state_rows, ended, p2, r2, taken, whole)
        moving = any_lane(ended <= RUNNING) and steps < settings[STEPS]
        if moving:
            factor = scale * where(size > LARGEST_STEP, LARGEST_STEP / where(size > LARGEST_STEP, size, 1.0), 1.0)
            for j in range(n_dof):
                store(trial_rows, j, within_bounds(load(q_rows, j) + factor * load(step_rows, j), bound_rows, j))
            new_p2, new_r2 = task_squares(settings, chain_pose(chain, trial_rows), target, jacobian_rows)
            better = ended <= RUNNING
            if method == JACOBIAN_TRANSPOSE:
                better = better & (new_p2 + new_r2 < least)
            for j in range(n_dof):
                q, new = load(q_rows, j), load(trial_rows, j)
                store(step_rows, j, where(better, new - q, 0.0))
                store(q_rows, j, where(better, new, q))
            least = where(better, new_p2 + new_r2, least)
            scale = where(better, 1.0, 0.5 * scale)
            taken = taken + where(ended <= RUNNING, 1.0, 0.0)
            steps += 1
            if trace.shape[0] > 0:
                trace_step(trace, steps, state_rows, step_rows, DAMPING if method == DAMPED_LEAST_SQUARES else 0.0)


@kernel
def trace_step(trace, steps, state_rows, step_rows, damping):
    """Write the errors before a step of lane 0 to the row before, its size and damping to the row of the step."""
    trace_errors(trace, steps - 1, state_rows)
    largest = 0.0
    for j in range(step_rows.shape[0]):
        largest = max(largest, abs(step_rows[j, 0]))
    trace[steps, 2], trace[steps, 3] = largest, damping


@kernel
def trace_errors(trace, k, state_rows):
    """Write the errors of lane 0 to row k."""
    e = state_rows[ERROR : ERROR + 6]
    trace[k, 0] = np.sqrt(e[0, 0] ** 2 + e[1, 0] ** 2 + e[2, 0] ** 2)
    trace[k, 1] = np.sqrt(e[3, 0] ** 2 + e[4, 0] ** 2 + e[5, 0] ** 2)


@entry((WHOLE, TABLE, MATRICES, MATRIX, MATRICES, NUMBERS, MATRIX, MATRIX, MATRIX))
def follow_each(method, chain, targets, seeds, bounds, settings, q_out, info, trace):
    """Search for each target of shape (n, 4, 4) from its seed: a target a lane.

    seeds: (n or 1, n_dof); bounds: (n or 1, 4, n_dof) of ``lane_state``; q_out: (n, n_dof); info: (n, N_INFO). trace:
    (0, 4), or (steps + 1, 4) and one target.
    """
    n, n_dof = q_out.shape
    rows, (jacobian_rows, system_rows) = search_state(n_dof)
    scratch = jacobian_rows, system_rows, empty_rows(6), empty_rows(n_dof)
    for start in range(0, n, WIDTH):
        gather(seeds, start, rows[0])
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            write_target(matrix_pose(targets[i]), rows[2], lane)
            write_bounds(bounds[min(i, bounds.shape[0] - 1)], rows[3], lane)
        descend(chain, method, settings, rows, scratch, trace)
        for lane in range(WIDTH):
            i = min(start + lane, n - 1)
            stopped = rows[4][ENDED, lane] == _HAS_STOPPED
            if rows[4][ENDED, lane] != HAS_SOLVED:
                rows[4][ENDED, lane] = HAS_FAILED
            rows[4][LAMBDA, lane] = DAMPING if method == DAMPED_LEAST_SQUARES else 0.0
            write_result(rows[0], rows[2], rows[4], lane, 0, i, q_out, info)
            if stopped:
                info[i, STATUS] = STATIONARY
            if not rigidity_defect(targets[i]) <= LARGEST_DEFECT:
                info[i, STATUS] = NOT_A_POSE
    if trace.shape[0] > 0:
        trace_errors(trace, int(info[0, ITERATIONS]), rows[4])
